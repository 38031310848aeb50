#include "tracker/thread_finder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "tests/support/synthetic_sequence.hpp"
#include "tests/support/tracking_trial.hpp"
#include "tracker/curve_distance.hpp"

namespace atropos::tracker {
namespace {

using support::SyntheticSequence;
using support::SyntheticSequenceOptions;

/// Both ends free, evenly gray ground.
SyntheticSequenceOptions bare(std::uint64_t seed) {
    return {.seed = seed, .clutter = false, .instruments = false};
}

scenes::Polyline line_of(const FoundThread& found) {
    scenes::Polyline line;
    for (const scenes::ThreadSample& sample : found.samples) line.points.push_back(sample.p_C);
    return line;
}

TEST(ThreadFinder, finds_a_thread_of_which_nothing_is_known) {
    for (const std::uint64_t seed : {1, 2, 3}) {
        const SyntheticSequence sequence(bare(seed));
        ThreadFinder finder(sequence.options().rig);
        const auto found = finder.find(support::stereo_frame(sequence.frame(0), 0));
        ASSERT_TRUE(found) << "seed " << seed;
        EXPECT_LT(symmetric_image_distance_px(line_of(*found), sequence.truth(0), sequence.options().rig),
                  0.5);
        EXPECT_NEAR(found->length_m, sequence.options().length_m, 0.04 * sequence.options().length_m);
        EXPECT_NEAR(found->row_offset_px, 0.0, 0.25);
    }
}

TEST(ThreadFinder, keeps_the_order_along_a_thread_that_crosses_itself) {
    SyntheticSequenceOptions options = bare(2);
    options.turning_rad = 4.6;
    options.turning_share = 0.5;
    const SyntheticSequence sequence(options);
    ThreadFinder finder(options.rig);
    const auto found = finder.find(support::stereo_frame(sequence.frame(0), 0));
    ASSERT_TRUE(found);
    scenes::Polyline line = line_of(*found);
    const scenes::Polyline truth = sequence.truth(0);
    if ((line.points.front() - truth.points.front()).norm() >
        (line.points.back() - truth.points.front()).norm())
        std::reverse(line.points.begin(), line.points.end());
    // At equal share of the length: a loop run through the wrong way is centimetres off.
    EXPECT_LT(arc_length_distance(line, truth).mean_m, 0.004);
}

TEST(ThreadFinder, prefers_the_thread_at_a_given_point_and_finds_none_away_from_it) {
    const SyntheticSequence sequence(bare(4));
    ThreadFinder finder(sequence.options().rig);
    const StereoFrame frame = support::stereo_frame(sequence.frame(0), 0);
    const scenes::Polyline truth = sequence.truth(0);
    EXPECT_TRUE(
        finder.find(frame, sequence.options().rig.project_left(truth.point_at(0.4 * truth.length_m()))));
    EXPECT_FALSE(finder.find(frame, Eigen::Vector2d(3.0, 3.0)));
}

/// A wall with vessels much like the thread, and two instruments that hold it.
SyntheticSequenceOptions cluttered(std::uint64_t seed) {
    return {.seed = seed};
}

TEST(ThreadFinder, tells_a_thread_from_vessels_by_its_standing_off_the_ground) {
    // Longer vessels than the thread, nearly as dark.
    for (const std::uint64_t seed : {6, 12, 20}) {
        const SyntheticSequence sequence(cluttered(seed));
        const auto found =
            ThreadFinder(sequence.options().rig).find(support::stereo_frame(sequence.frame(0), 0));
        ASSERT_TRUE(found) << "seed " << seed;
        EXPECT_EQ(found->doubt, Doubt::kNone) << "seed " << seed;
        EXPECT_LT(symmetric_image_distance_px(line_of(*found), sequence.truth(0), sequence.options().rig),
                  1.5)
            << "seed " << seed;
    }
}

TEST(ThreadFinder, is_not_led_astray_by_a_vessel_that_meets_the_thread_at_a_flat_angle) {
    const SyntheticSequence sequence(cluttered(34));
    const auto found = ThreadFinder(sequence.options().rig).find(support::stereo_frame(sequence.frame(0), 0));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->doubt, Doubt::kNone);
    EXPECT_LT(symmetric_image_distance_px(line_of(*found), sequence.truth(0), sequence.options().rig), 1.5);
}

TEST(ThreadFinder, doubts_an_end_that_one_eye_alone_sees) {
    const SyntheticSequence sequence(bare(1));
    StereoFrame frame = support::stereo_frame(sequence.frame(0), 0);
    const Eigen::Vector2d end = sequence.options().rig.project_right(sequence.truth(0).points.back());
    const int level = frame.right.at<unsigned char>(5, 5);
    cv::circle(frame.right, {static_cast<int>(end.x()), static_cast<int>(end.y())}, 60, level, -1);
    const auto found = ThreadFinder(sequence.options().rig).find(frame);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->doubt, Doubt::kEnd);
}

TEST(ThreadFinder, doubts_which_of_two_threads_is_meant_but_not_with_a_point_given) {
    SyntheticSequenceOptions options = bare(1);
    options.heading_rad = 0.7;
    options.length_m = 0.03;
    const SyntheticSequence sequence(options);
    StereoFrame frame = support::stereo_frame(sequence.frame(0), 0);
    // The same thread once more, further down.
    for (cv::Mat* image : {&frame.left, &frame.right}) {
        cv::Mat twice = cv::min(*image, 0.0 * *image + 255.0);
        constexpr int kDown = 90;
        const cv::Mat upper = (*image)(cv::Rect(0, 0, image->cols, image->rows - kDown));
        cv::Mat lower = twice(cv::Rect(0, kDown, image->cols, image->rows - kDown));
        cv::min(lower, upper, lower);
        *image = twice;
    }
    ThreadFinder finder(options.rig);
    const auto found = finder.find(frame);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->doubt, Doubt::kRival);
    const scenes::Polyline truth = sequence.truth(0);
    const auto named = finder.find(frame, options.rig.project_left(truth.point_at(0.5 * truth.length_m())));
    ASSERT_TRUE(named);
    EXPECT_EQ(named->doubt, Doubt::kNone);
    EXPECT_LT(symmetric_image_distance_px(line_of(*named), truth, options.rig), 1.0);
}

TEST(ThreadFinder, finds_nothing_where_nothing_is) {
    const scenes::StereoRig rig = scenes::parallel_rig(640, 360, 575.0, 0.005);
    StereoFrame frame;
    frame.left = frame.right = cv::Mat1b(360, 640, static_cast<unsigned char>(128));
    EXPECT_FALSE(ThreadFinder(rig).find(frame));
    frame.right = cv::Mat1b(100, 100, static_cast<unsigned char>(128));
    EXPECT_THROW(ThreadFinder(rig).find(frame), std::invalid_argument);
}

TEST(RectifiedView, turns_the_right_eye_by_a_row_offset) {
    const scenes::StereoRig rig = scenes::parallel_rig(640, 480, 883.0, 0.006);
    const Eigen::Vector3d p(0.002, 0.0, 0.1);
    const Eigen::Vector2d before = rig.project_right(p),
                          after = RectifiedView(rig).with_row_offset(1.5).project_right(p);
    EXPECT_NEAR(after.y() - before.y(), 1.5, 1e-3);
    EXPECT_NEAR(after.x() - before.x(), 0.0, 0.01);
}

}  // namespace
}  // namespace atropos::tracker
