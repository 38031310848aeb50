#include "tracker/thread_tracker.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/tracking_trial.hpp"
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
    const Drawn drawn({.seed = 7, .rig = kSmallRig});
    scenes::TrackerConfig config;
    const auto found = [&] {
        const auto tracker = make_tracker(config, kSmallRig);
        return tracker->start(drawn.frame, drawn.curve()).control_points;
    };
    const std::vector<Eigen::Vector3d> plain = found();
    config.threads = 3;
    EXPECT_EQ(found(), plain);
    config.cost_image.region_of_interest = false;
    EXPECT_EQ(found(), plain);
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
