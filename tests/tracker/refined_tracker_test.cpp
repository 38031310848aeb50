#include "tracker/refined_tracker.hpp"

#include <gtest/gtest.h>

#include "tests/support/synthetic_sequence.hpp"

namespace atropos::tracker {
namespace {

using support::SyntheticFrame;
using support::SyntheticSequence;
using support::SyntheticSequenceOptions;

StereoFrame frame_of(const SyntheticFrame& drawn, int index) {
    StereoFrame frame;
    frame.index = index;
    frame.capture_time_s = drawn.time_s;
    frame.left = drawn.left;
    frame.right = drawn.right;
    for (std::size_t end = 0; end < 2; ++end) frame.tips[end] = MeasuredTip{drawn.tips_C[end]};
    frame.instruments = drawn.instruments_C;
    return frame;
}

scenes::TrackerConfig config_for(const SyntheticSequenceOptions& options) {
    scenes::TrackerConfig config;
    config.method = scenes::TrackerMethod::kRefined;
    config.thread.length_m = options.length_m;
    config.thread.width_m = options.width_m;
    config.thread.polarity = options.dark ? scenes::ThreadPolarity::kDark : scenes::ThreadPolarity::kBright;
    return config;
}

double mean_distance_m(const scenes::ThreadEstimate& estimate, const scenes::Polyline& truth) {
    double sum = 0.0;
    for (const scenes::ThreadSample& sample : estimate.samples) sum += truth.nearest(sample.p_C).distance_m;
    return sum / static_cast<double>(estimate.samples.size());
}

NurbsCurve initial_curve(const scenes::Polyline& truth) {
    return fit_curve(truth, {.control_points = 12, .length_weight = 0.3});
}

/// Shows the tracker the first `frames` of a sequence, begun from the truth, and each result to `look`.
template <typename Look>
void track(const SyntheticSequenceOptions& options, int frames, Look&& look) {
    const SyntheticSequence sequence(options);
    RefinedTracker tracker(config_for(options), options.rig);
    for (int i = 0; i < frames; ++i) {
        const SyntheticFrame drawn = sequence.frame(i);
        look(i, drawn,
             i == 0 ? tracker.start(frame_of(drawn, i), initial_curve(drawn.truth_C))
                    : tracker.track(frame_of(drawn, i)));
    }
}

double mean_error_m(const SyntheticSequenceOptions& options, int frames) {
    double sum = 0.0;
    track(options, frames, [&](int, const SyntheticFrame& drawn, const TrackResult& result) {
        sum += mean_distance_m(result.estimate, drawn.truth_C);
    });
    return sum / frames;
}

/// Error of the last frame of a short sequence that is tracked throughout.
double error_after(const SyntheticSequenceOptions& options, int frames) {
    double error = 0.0;
    track(options, frames, [&](int i, const SyntheticFrame& drawn, const TrackResult& result) {
        EXPECT_EQ(result.estimate.status, scenes::TrackStatus::kTracking) << "frame " << i;
        error = mean_distance_m(result.estimate, drawn.truth_C);
    });
    return error;
}

TEST(RefinedTracker, follows_a_thread_over_clutter_to_a_fraction_of_a_millimetre) {
    EXPECT_LT(error_after({.seed = 31, .acceleration = 3}, 12), 0.0004);
}

TEST(RefinedTracker, finds_the_middle_from_grips_that_are_measured_millimetres_off) {
    const SyntheticSequenceOptions options{
        .seed = 101, .tip_error_m = 0.003, .tip_jitter_m = 0.0003, .jaws = true, .tail_m = 0.004};
    double error_m = 0.0, tips_m = 0.0;
    track(options, 24, [&](int i, const SyntheticFrame& drawn, const TrackResult& result) {
        if (i < 12) return;
        const std::vector<scenes::ThreadSample>& samples = result.estimate.samples;
        const Eigen::Vector3d middle = drawn.truth_C.point_at(0.5 * drawn.truth_C.length_m());
        error_m += (samples[samples.size() / 2].p_C - middle).norm() / 12.0;
        tips_m += (drawn.tips_C[0] - drawn.truth_C.points.front()).norm() / 12.0;
    });
    EXPECT_GT(tips_m, 0.001);
    EXPECT_LT(error_m, 0.0004);
}

TEST(RefinedTracker, leaves_well_measured_ends_where_they_are_while_a_vessel_runs_along_the_thread) {
    EXPECT_LT(mean_error_m({.seed = 105}, 30), 0.00025);
}

TEST(RefinedTracker, does_not_claim_a_curve_whose_end_is_where_no_arm_is) {
    const SyntheticSequenceOptions options{.seed = 31};
    const SyntheticFrame drawn = SyntheticSequence(options).frame(0);
    StereoFrame frame = frame_of(drawn, 0);
    frame.tips[0]->p_C += 0.010 * Eigen::Vector3d::UnitY();
    RefinedTracker tracker(config_for(options), options.rig);
    const TrackResult& result = tracker.start(frame, initial_curve(drawn.truth_C));
    EXPECT_GT(result.support, 0.8);
    EXPECT_NE(result.estimate.status, scenes::TrackStatus::kTracking);
}

TEST(RefinedTracker, stays_on_a_thread_that_is_hardly_darker_than_the_noise) {
    const SyntheticSequenceOptions options{.seed = 3, .contrast = 14.0};
    double mean_m = 0.0;
    track(options, 24, [&](int i, const SyntheticFrame& drawn, const TrackResult& result) {
        EXPECT_EQ(result.estimate.status, scenes::TrackStatus::kTracking) << "frame " << i;
        mean_m += mean_distance_m(result.estimate, drawn.truth_C) / 24.0;
    });
    EXPECT_LT(mean_m, 0.0006);
}

TEST(RefinedTracker, follows_a_bright_thread) {
    EXPECT_LT(error_after({.seed = 32, .dark = false}, 6), 0.0004);
}

TEST(RefinedTracker, is_as_good_on_converging_distorted_cameras) {
    SyntheticSequenceOptions options{.seed = 33};
    options.rig.left.distortion = {-0.12, 0.05, 0.001, -0.001, 0.0, 0.0, 0.0, 0.0};
    options.rig.right.distortion = {-0.11, 0.04, -0.001, 0.001, 0.0, 0.0, 0.0, 0.0};
    options.rig.X_RC.linear() = Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitY()).toRotationMatrix();
    EXPECT_LT(error_after(options, 6), 0.0004);
}

TEST(RefinedTracker, goes_on_from_a_stored_state_as_if_it_had_never_stopped) {
    const SyntheticSequenceOptions options{.seed = 34};
    const SyntheticSequence sequence(options);
    RefinedTracker whole(config_for(options), options.rig);
    RefinedTracker resumed(config_for(options), options.rig);
    const SyntheticFrame first = sequence.frame(0);
    whole.start(frame_of(first, 0), initial_curve(first.truth_C));
    whole.track(frame_of(sequence.frame(1), 1));
    resumed.restore(whole.state());
    const StereoFrame next = frame_of(sequence.frame(2), 2);
    EXPECT_EQ(whole.track(next).control_points, resumed.track(next).control_points);
    EXPECT_EQ(whole.state().method_state, resumed.state().method_state);
}

TEST(RefinedTracker, gives_no_estimate_without_a_start_or_ends) {
    const SyntheticSequenceOptions options{.seed = 35};
    RefinedTracker tracker(config_for(options), options.rig);
    StereoFrame frame = frame_of(SyntheticSequence(options).frame(0), 0);
    frame.tips = {};
    const TrackResult& result = tracker.track(frame);
    EXPECT_EQ(result.estimate.status, scenes::TrackStatus::kLost);
    EXPECT_TRUE(result.estimate.samples.empty());
}

TEST(RefinedTracker, admits_that_it_sees_nothing_in_black_images) {
    const SyntheticSequenceOptions options{.seed = 36};
    const SyntheticSequence sequence(options);
    scenes::TrackerConfig config = config_for(options);
    config.refined.coasting_frames = 3;
    RefinedTracker tracker(config, options.rig);
    const SyntheticFrame first = sequence.frame(0);
    tracker.start(frame_of(first, 0), initial_curve(first.truth_C));
    StereoFrame black = frame_of(first, 1);
    black.left = cv::Mat::zeros(first.left.size(), CV_8UC1);
    black.right = black.left.clone();
    for (int i = 1; i <= 5; ++i) {
        black.index = i;
        const TrackResult& result = tracker.track(black);
        EXPECT_NE(result.estimate.status, scenes::TrackStatus::kTracking);
        for (const scenes::ThreadSample& sample : result.estimate.samples)
            EXPECT_TRUE(sample.p_C.allFinite());
        EXPECT_EQ(result.estimate.status == scenes::TrackStatus::kLost, i > 3);
    }
}

}  // namespace
}  // namespace atropos::tracker
