#include "tracker/thread_tracker.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/table_cases.hpp"
#include "tracker/thread_initialiser.hpp"

namespace atropos::tracker {
namespace {

using support::SyntheticSequence;
using support::SyntheticSequenceOptions;

const scenes::StereoRig kSmallRig = scenes::parallel_rig(320, 180, 287.5, 0.005);

struct Drawn {
    explicit Drawn(const SyntheticSequenceOptions& options, int index = 0)
        : picture(SyntheticSequence(options).frame(index)), frame(support::stereo_frame(picture, index)) {}
    support::SyntheticFrame picture;
    StereoFrame frame;
    NurbsCurve curve() const { return fit_curve(picture.truth_C, {.length_weight = 1.0}); }
};

TEST(ThreadTracker, follows_a_thread_over_clutter_with_both_energies) {
    scenes::TrackerConfig e1;
    e1.method = scenes::TrackerMethod::kE1;
    const auto scores =
        support::run_trials({e1, scenes::TrackerConfig{}}, SyntheticSequenceOptions{.seed = 7}, 6);
    for (const std::vector<support::FrameScore>& of_one : scores) {
        const support::TrialSummary found = support::summary(of_one);
        EXPECT_LT(found.mean_2d_px, 1.0);
        EXPECT_EQ(found.failed_percent, 0.0);
    }
}

TEST(ThreadTracker, gives_the_same_bytes_for_any_number_of_threads_and_region) {
    for (const char* camera : {"default", "converging", "distorted"})
        for (const auto shape : {scenes::LabelShape::kCube, scenes::LabelShape::kRays})
            for (const auto unknowns : {scenes::Parameterisation::k3d, scenes::Parameterisation::k2d}) {
                scenes::StereoRig rig = support::table_case(camera).options.rig.scaled(0.5);
                const Drawn drawn({.seed = 7, .rig = rig});
                scenes::TrackerConfig config;
                config.labels.r = 2;
                config.labels.shape = shape;
                config.parameterisation = unknowns;
                const auto found = [&] {
                    const auto tracker = make_tracker(config, rig);
                    return tracker->start(drawn.frame, drawn.curve()).control_points;
                };
                const std::vector<Eigen::Vector3d> plain = found();
                config.threads = 3;
                EXPECT_EQ(found(), plain) << camera;
                config.cost_image.region_of_interest = false;
                EXPECT_EQ(found(), plain) << camera;
            }
}

TEST(ThreadTracker, sees_as_well_with_converging_and_distorted_eyes) {
    const auto error_px = [](const char* camera) {
        support::TableCase c = support::table_case(camera);
        c.options.seed = 7;
        return support::summary(support::run_trial(c.e2, c.options, 6)).mean_2d_px;
    };
    const double pinhole_px = error_px("default");
    EXPECT_LT(error_px("converging"), 1.2 * pinhole_px);
    EXPECT_LT(error_px("distorted"), 1.2 * pinhole_px);
}

TEST(ThreadTracker, finds_a_lost_thread_again_between_its_ends) {
    const Drawn drawn({.seed = 7, .rig = kSmallRig});
    StereoFrame black = drawn.frame;
    black.left = cv::Mat1b(drawn.frame.left.size(), 0);
    black.right = cv::Mat1b(drawn.frame.left.size(), 0);
    scenes::TrackerConfig config;
    config.thread.length_m = 0.07;
    const auto tracker = make_tracker(config, kSmallRig);
    NurbsCurve elsewhere = drawn.curve();
    std::vector<Eigen::Vector3d> points = elsewhere.control_points();
    for (Eigen::Vector3d& q : points) q.y() -= 0.03;
    elsewhere.set_control_points(points);
    tracker->start(black, elsewhere);
    for (int i = 0; i < 12; ++i) tracker->track(black);
    ASSERT_EQ(tracker->track(black).estimate.status, scenes::TrackStatus::kLost);
    for (int i = 0; i < 10; ++i) tracker->track(drawn.frame);
    EXPECT_EQ(tracker->track(drawn.frame).estimate.status, scenes::TrackStatus::kTracking);
}

TEST(ThreadTracker, repeats_from_a_stored_state) {
    const Drawn first({.seed = 8, .rig = kSmallRig});
    const Drawn second({.seed = 8, .rig = kSmallRig}, 5);
    const auto tracker = make_tracker({}, kSmallRig);
    tracker->start(first.frame, first.curve());
    const TrackerState state = tracker->state();
    const std::vector<Eigen::Vector3d> went_on = tracker->track(second.frame).control_points;
    const auto other = make_tracker({}, kSmallRig);
    other->restore(state);
    EXPECT_EQ(other->track(second.frame).control_points, went_on);
}

TEST(ThreadTracker, is_lost_where_there_is_no_thread) {
    const Drawn drawn({.seed = 7, .rig = kSmallRig});
    StereoFrame black = drawn.frame;
    black.left = cv::Mat1b(drawn.frame.left.size(), 0);
    black.right = cv::Mat1b(drawn.frame.left.size(), 0);
    const auto unstarted = make_tracker({}, kSmallRig);
    EXPECT_EQ(unstarted->track(black).estimate.status, scenes::TrackStatus::kLost);
    const auto tracker = make_tracker({}, kSmallRig);
    tracker->start(drawn.frame, drawn.curve());
    EXPECT_EQ(tracker->track(black).estimate.status, scenes::TrackStatus::kCoasting);
    for (const scenes::ThreadSample& sample : tracker->track(black).estimate.samples)
        EXPECT_TRUE(sample.p_C.allFinite());
    for (int i = 0; i < 10; ++i) tracker->track(black);
    const TrackResult& result = tracker->track(black);
    EXPECT_EQ(result.estimate.status, scenes::TrackStatus::kLost);
    EXPECT_TRUE(result.estimate.samples.empty());
}

TEST(ThreadTracker, states_one_sigma_in_pixels_of_a_640_px_wide_image) {
    const Drawn drawn({.seed = 7, .rig = kSmallRig});
    scenes::TrackerConfig config;
    config.uncertainty = {.lateral_px = 0.5, .disparity_px = 0.2};
    const auto tracker = make_tracker(config, kSmallRig);
    for (const scenes::ThreadSample& sample : tracker->start(drawn.frame, drawn.curve()).estimate.samples) {
        const double z_m = sample.p_C.z();
        EXPECT_NEAR(sample.sigma_lateral_m, 0.25 * z_m / 287.5, 1e-12);
        EXPECT_NEAR(sample.sigma_depth_m, 0.1 * z_m * z_m / (287.5 * 0.005), 1e-12);
    }
    EXPECT_GT(stated_uncertainty({}).lateral_px, 0.0);
    EXPECT_EQ(stated_uncertainty(config).disparity_px, 0.2);
}

TEST(ThreadTracker, refuses_frames_that_do_not_fit_the_rig) {
    const Drawn drawn({.seed = 7, .rig = kSmallRig});
    const auto tracker = make_tracker({}, kSmallRig);
    const auto refused = [&](auto change) {
        StereoFrame frame = drawn.frame;
        change(frame);
        EXPECT_THROW(tracker->track(frame), std::invalid_argument);
    };
    refused([](StereoFrame& f) { f.right = cv::Mat(); });
    refused([](StereoFrame& f) { f.left = cv::Mat1b(1, 1); });
    refused([](StereoFrame& f) { f.left = cv::Mat1w(180, 320); });
    refused([](StereoFrame& f) { f.tips[0]->p_C.x() = std::numeric_limits<double>::quiet_NaN(); });
    refused([](StereoFrame& f) { f.tips[1]->p_C.z() = -0.1; });
}

TEST(ThreadTracker, takes_a_picture_of_one_pixel) {
    const scenes::StereoRig rig = scenes::parallel_rig(1, 1, 575.0, 0.005);
    StereoFrame frame;
    frame.left = cv::Mat1b(1, 1, std::uint8_t{7});
    frame.right = cv::Mat1b(1, 1, std::uint8_t{7});
    frame.tips = {MeasuredTip{.p_C = {-0.03, 0.0, 0.1}}, MeasuredTip{.p_C = {0.03, 0.0, 0.1}}};
    EXPECT_EQ(make_tracker({}, rig)->track(frame).estimate.status, scenes::TrackStatus::kLost);
}

TEST(ThreadTracker, keeps_a_fixed_end_exactly) {
    const Drawn drawn({.seed = 7, .rig = kSmallRig});
    StereoFrame frame = drawn.frame;
    frame.tips[1]->kind = MeasuredTip::Kind::kFixed;
    const auto tracker = make_tracker({}, kSmallRig);
    EXPECT_EQ(tracker->start(frame, drawn.curve()).control_points.back(), frame.tips[1]->p_C);
}

TEST(ThreadInitialiser, makes_a_straight_line_of_even_speed) {
    const NurbsCurve line(3, straight_line(3, 8, {0, 0, 0.1}, {0.06, 0.01, 0.11}));
    for (int j = 0; j <= 20; ++j)
        EXPECT_NEAR((line.derivative(j / 20.0) - Eigen::Vector3d(0.06, 0.01, 0.01)).norm(), 0.0, 1e-13);
}

TEST(ThreadInitialiser, finds_random_curves_from_the_straight_line) {
    for (int i = 0; i < 6; ++i) {
        const std::optional<double> error_px = support::error_from_straight_line_px(
            support::start_options(1000 + static_cast<std::uint64_t>(i), 0.77 + 0.03 * i));
        ASSERT_TRUE(error_px) << i;
        EXPECT_LT(*error_px, 2.0) << i;
    }
}

TEST(TrackerConfig, is_refused_where_a_value_makes_no_sense) {
    scenes::TrackerConfig config;
    config.labels.r = 0;
    EXPECT_THROW(make_tracker(config, kSmallRig), std::invalid_argument);
    config = {};
    config.curve.control_points = 3;
    EXPECT_THROW(make_tracker(config, kSmallRig), std::invalid_argument);
    config = {};
    config.thread.length_is_known = true;
    EXPECT_THROW(make_tracker(config, kSmallRig), std::invalid_argument);
}

}  // namespace
}  // namespace atropos::tracker
