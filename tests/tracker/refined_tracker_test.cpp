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

/// From the points of the true thread at the same arc length, at most: what slides along the thread is off.
double order_error_m(const scenes::ThreadEstimate& estimate, const scenes::Polyline& truth) {
    const scenes::Polyline even = truth.resampled(static_cast<int>(estimate.samples.size()));
    double most = 0.0;
    for (std::size_t i = 0; i < even.points.size(); ++i)
        most = std::max(most, (estimate.samples[i].p_C - even.points[i]).norm());
    return most;
}

/// A thread that crosses itself; its loop goes to and fro along it.
SyntheticSequenceOptions travelling_loop(std::uint64_t seed) {
    SyntheticSequenceOptions options{.seed = seed};
    options.turning_rad = 4.7;
    options.turning_share = 0.45;
    options.travel_share = 0.14;
    return options;
}

TEST(RefinedTracker, does_not_slide_along_a_thread_whose_loop_travels) {
    track(travelling_loop(11), 40, [](int i, const SyntheticFrame& drawn, const TrackResult& result) {
        ASSERT_EQ(result.estimate.status, scenes::TrackStatus::kTracking) << "frame " << i;
        EXPECT_LT(order_error_m(result.estimate, drawn.truth_C), 0.002) << "frame " << i;
    });
}

// Bending that costs as much in a loop as elsewhere draws the loop tight and the ends in.
TEST(RefinedTracker, keeps_a_loop_as_wide_as_it_is) {
    double off_m = 0.0;
    int samples = 0;
    for (const std::uint64_t seed : {2u, 5u})
        track(travelling_loop(seed), 30, [&](int, const SyntheticFrame& drawn, const TrackResult& result) {
            for (const scenes::ThreadSample& sample : result.estimate.samples) {
                off_m += drawn.truth_C.nearest(sample.p_C).distance_m;
                ++samples;
            }
        });
    ASSERT_GT(samples, 0);
    EXPECT_LT(off_m / samples, 0.0002);
}

TEST(RefinedTracker, takes_more_control_points_when_a_loop_is_formed) {
    SyntheticSequenceOptions options{.seed = 11};
    options.turning_rad = 3.7;
    options.turning_swing_rad = 1.5;
    options.turning_share = 0.45;
    options.acceleration = 4;
    std::size_t first = 0, last = 0;
    track(options, 15, [&](int i, const SyntheticFrame&, const TrackResult& result) {
        (i == 0 ? first : last) = result.control_points.size();
    });
    EXPECT_LT(first, last);
    EXPECT_EQ(last, 40u);
}

TEST(RefinedTracker, finds_a_thread_in_a_loop_between_its_ends) {
    SyntheticSequenceOptions options = travelling_loop(11);
    options.travel_share = 0.0;
    options.clutter = false;
    const SyntheticSequence sequence(options);
    RefinedTracker tracker(config_for(options), options.rig);
    for (int i = 0; i < 5; ++i) {
        const SyntheticFrame drawn = sequence.frame(i);
        const TrackResult& result = tracker.track(frame_of(drawn, i));
        if (i < 4) continue;
        ASSERT_EQ(result.estimate.status, scenes::TrackStatus::kTracking);
        EXPECT_LT(order_error_m(result.estimate, drawn.truth_C), 0.002);
    }
}

TEST(RefinedTracker, does_not_take_a_start_for_found_that_no_image_shows) {
    SyntheticSequenceOptions options = travelling_loop(11);  // between its ends the curve hangs out of sight
    options.clutter = false;
    const SyntheticFrame drawn = SyntheticSequence(options).frame(0);
    RefinedTracker tracker(config_for(options), options.rig);
    EXPECT_EQ(tracker.track(frame_of(drawn, 0)).estimate.status, scenes::TrackStatus::kLost);
}

TEST(RefinedTracker, is_as_good_on_converging_distorted_cameras) {
    SyntheticSequenceOptions options{.seed = 33};
    options.rig.left.distortion = {-0.12, 0.05, 0.001, -0.001, 0.0, 0.0, 0.0, 0.0};
    options.rig.right.distortion = {-0.11, 0.04, -0.001, 0.001, 0.0, 0.0, 0.0, 0.0};
    options.rig.X_RC.linear() = Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitY()).toRotationMatrix();
    EXPECT_LT(error_after(options, 6), 0.0004);
}

/// What a tracker is told beside the pictures.
struct Told {
    scenes::StereoRig rig;
    double length_m = 0.070;
    double row_sigma_px = 0.0;
};
struct Outcome {
    double mean_m = 0.0;  ///< error
    TrackResult last;
};
Outcome outcome_when_told(const Told& told, const SyntheticSequenceOptions& options, int frames) {
    const SyntheticSequence sequence(options);
    scenes::TrackerConfig config = config_for(options);
    config.thread.length_m = told.length_m;
    config.refined.row_sigma_px = told.row_sigma_px;
    RefinedTracker tracker(config, told.rig);
    Outcome outcome;
    for (int i = 0; i < frames; ++i) {
        const SyntheticFrame drawn = sequence.frame(i);
        StereoFrame frame = frame_of(drawn, i);
        if (options.free_end) frame.tips[1].reset();
        outcome.last = i == 0 ? tracker.start(frame, initial_curve(drawn.truth_C)) : tracker.track(frame);
        outcome.mean_m += mean_distance_m(outcome.last.estimate, drawn.truth_C) / frames;
    }
    return outcome;
}

scenes::StereoRig with_right_eye_off(scenes::StereoRig rig, const EyeCorrection& error) {
    rig.right.cy_px -= error.row_px;
    rig.X_RC = Eigen::AngleAxisd(-error.roll_rad, Eigen::Vector3d::UnitZ()) * rig.X_RC;
    return rig;
}

TEST(RefinedTracker, finds_what_the_right_eye_is_off_by_in_rows_and_roll) {
    const SyntheticSequenceOptions options{.seed = 3};  // its thread runs nowhere along the rows
    const EyeCorrection error{1.5, 0.0035};
    const scenes::StereoRig off = with_right_eye_off(options.rig, error);
    const Outcome found = outcome_when_told({.rig = off, .row_sigma_px = 1.0}, options, 10);
    ASSERT_TRUE(found.last.eye);
    EXPECT_NEAR(found.last.eye->correction.row_px, error.row_px, 0.06);
    EXPECT_NEAR(found.last.eye->correction.roll_rad, error.roll_rad, 0.0004);
    EXPECT_LT(found.last.eye->sigmas().row_px, 0.05);
    const Outcome right = outcome_when_told({.rig = options.rig}, options, 10);
    EXPECT_LT(found.mean_m, 1.5 * right.mean_m);
}

TEST(RefinedTracker, takes_the_rig_for_right_unless_told_otherwise) {
    const SyntheticSequenceOptions options{.seed = 3};
    EXPECT_FALSE(outcome_when_told({.rig = options.rig}, options, 2).last.eye);
}

TEST(RefinedTracker, finds_the_length_of_a_thread_that_is_said_to_be_a_tenth_longer_or_shorter) {
    const SyntheticSequenceOptions options{.seed = 2};
    const Outcome right = outcome_when_told({.rig = options.rig}, options, 24);
    EXPECT_FALSE(right.last.length_refuted);
    for (const double told_m : {0.063, 0.077}) {
        const Outcome wrong = outcome_when_told({.rig = options.rig, .length_m = told_m}, options, 24);
        EXPECT_TRUE(wrong.last.length_refuted) << told_m;
        EXPECT_NEAR(wrong.last.estimate.length_m(), 0.070, 0.02 * 0.070) << told_m;
        EXPECT_LT(wrong.mean_m, 1.5 * right.mean_m) << told_m;
    }
}

TEST(RefinedTracker, believes_a_length_that_is_right_though_the_arms_are_millimetres_off) {
    for (const std::uint64_t seed : {1, 2, 3}) {
        const SyntheticSequenceOptions options{.seed = seed, .tip_error_m = 0.003};
        EXPECT_FALSE(outcome_when_told({.rig = options.rig}, options, 1).last.length_refuted) << seed;
    }
}

TEST(RefinedTracker, sees_where_a_thread_ends_that_nothing_holds) {
    const SyntheticSequenceOptions options{.seed = 2, .free_end = true};
    const Outcome unknown = outcome_when_told({.rig = options.rig, .length_m = 0.0}, options, 24);
    EXPECT_NEAR(unknown.last.estimate.length_m(), 0.070, 0.02 * 0.070);
}

TEST(RefinedTracker, goes_on_from_a_stored_state_with_an_eye_that_is_off) {
    const SyntheticSequenceOptions options{.seed = 4};
    const SyntheticSequence sequence(options);
    scenes::TrackerConfig config = config_for(options);
    config.refined.row_sigma_px = 1.0;
    const scenes::StereoRig off = with_right_eye_off(options.rig, {1.0, 0.002});
    RefinedTracker tracker(config, off), other(config, off);
    const SyntheticFrame first = sequence.frame(0), second = sequence.frame(1), third = sequence.frame(2);
    tracker.start(frame_of(first, 0), initial_curve(first.truth_C));
    tracker.track(frame_of(second, 1));
    other.restore(tracker.state());
    const TrackResult a = tracker.track(frame_of(third, 2));
    const TrackResult b = other.track(frame_of(third, 2));
    ASSERT_EQ(a.control_points.size(), b.control_points.size());
    for (std::size_t k = 0; k < a.control_points.size(); ++k)
        EXPECT_EQ(a.control_points[k], b.control_points[k]) << k;
    EXPECT_EQ(a.eye->correction.row_px, b.eye->correction.row_px);
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
