#include "experiments/metrics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace atropos::experiments {
namespace {
using scenes::Polyline;
using scenes::ThreadEstimate;
using scenes::TrackStatus;

const scenes::StereoRig kRig = scenes::parallel_rig(640, 360, 575.0, 0.005);

Polyline line(double x0, double x1, double y, double z, int n = 101) {
    Polyline p;
    for (int i = 0; i < n; ++i) p.points.emplace_back(x0 + (x1 - x0) * i / (n - 1), y, z);
    return p;
}

ThreadEstimate estimate_of(const Polyline& p, double sigma_lateral = 0.0, double sigma_depth = 0.0) {
    ThreadEstimate e;
    e.status = TrackStatus::kTracking;
    const auto s = p.arc_lengths_m();
    for (size_t i = 0; i < s.size(); ++i)
        e.samples.push_back({s[i], p.points[i], sigma_lateral, sigma_depth});
    return e;
}

TEST(Metrics, of_the_truth_itself_are_zero) {
    const Polyline truth = line(-0.03, 0.03, 0.0, 0.1);
    const FrameMetrics m = compare(estimate_of(truth), truth, kRig);
    for (const auto& [name, field] : metric_fields())
        EXPECT_NEAR(name.starts_with("coverage") ? 0.0 : m.*field, 0.0, 1e-9) << name;
}

TEST(Metrics, of_a_sideways_shift_are_the_shift) {
    const FrameMetrics m =
        compare(estimate_of(line(-0.03, 0.03, 0.001, 0.1)), line(-0.03, 0.03, 0.0, 0.1), kRig);
    EXPECT_NEAR(m.accuracy_3d_mm, 1.0, 1e-9);
    EXPECT_NEAR(m.symmetric_3d_mm, 1.0, 1e-9);
    EXPECT_NEAR(m.accuracy_2d_px, 5.75, 1e-9);
    EXPECT_NEAR(m.symmetric_2d_px, 5.75, 1e-9);
    EXPECT_NEAR(m.midpoint_mm, 1.0, 1e-9);
    EXPECT_NEAR(m.tip_mm, 1.0, 1e-9);
    EXPECT_NEAR(m.end_slide_px, 0.0, 1e-9);
    EXPECT_NEAR(m.disparity_equivalent_px, 0.001 / (0.01 / (575.0 * 0.005)), 1e-9);
}

TEST(Metrics, see_a_slide_that_the_one_sided_distance_hides) {
    const FrameMetrics m =
        compare(estimate_of(line(-0.028, 0.028, 0.0, 0.1)), line(-0.03, 0.03, 0.0, 0.1), kRig);
    EXPECT_NEAR(m.accuracy_3d_mm, 0.0, 1e-9);
    EXPECT_GT(m.symmetric_3d_mm, 0.02);
    EXPECT_NEAR(m.tip_mm, 2.0, 1e-9);
    EXPECT_NEAR(m.end_slide_px, 2.0 * 5.75, 1e-6);
    EXPECT_NEAR(m.length_error_percent, -100.0 * 4.0 / 60.0, 1e-9);
}

TEST(Metrics, one_sided_distance_agrees_with_dense_sampling_of_a_circle) {
    // Eq. 22 on an arc of radius r against the concentric one: the distance is the difference of radii
    // everywhere.
    Polyline inner, outer;
    for (int i = 0; i <= 20000; ++i) {
        const double a = std::numbers::pi * i / 20000;
        inner.points.emplace_back(0.020 * std::cos(a), 0.020 * std::sin(a), 0.1);
        outer.points.emplace_back(0.021 * std::cos(a), 0.021 * std::sin(a), 0.1);
    }
    const FrameMetrics m = compare(estimate_of(outer.resampled(101)), inner, kRig);
    EXPECT_NEAR(m.accuracy_3d_mm, 1.0, 1e-4);
}

TEST(Metrics, coverage_counts_samples_within_their_sigmas_along_and_across_the_ray) {
    const Polyline truth = line(-0.0001, 0.0001, 0.0, 0.1), deeper = line(-0.0001, 0.0001, 0.0, 0.1015);
    const FrameMetrics m = compare(estimate_of(deeper, 1e-4, 1e-3), truth, kRig);
    EXPECT_NEAR(m.coverage_depth_1_sigma, 0.0, 1e-9);
    EXPECT_NEAR(m.coverage_depth_2_sigma, 1.0, 1e-9);
    EXPECT_NEAR(m.coverage_lateral_1_sigma, 1.0, 1e-9);
}

EvaluatedFrame frame(int index, TrackStatus status, double symmetric_px, double symmetric_mm = 0.1) {
    EvaluatedFrame f{index, status, status != TrackStatus::kLost, {}};
    f.metrics.symmetric_2d_px = symmetric_px;
    f.metrics.symmetric_3d_mm = symmetric_mm;
    return f;
}

TEST(Metrics, summary_counts_losses_as_the_design_says) {
    std::vector<EvaluatedFrame> frames;
    for (int i = 0; i < 10; ++i) frames.push_back(frame(i, TrackStatus::kTracking, 1.0));
    for (int i = 10; i < 13; ++i)
        frames.push_back(frame(i, TrackStatus::kTracking, 9.0));  // a silent failure
    for (int i = 13; i < 15; ++i) frames.push_back(frame(i, TrackStatus::kLost, 0.0));
    for (int i = 15; i < 25; ++i) frames.push_back(frame(i, TrackStatus::kTracking, 1.0));
    frames.push_back(frame(25, TrackStatus::kTracking, 1.0, 4.0));  // wrong in depth, and sure of it
    const auto s = summarise(frames);
    EXPECT_EQ(s["frames"], 26);
    EXPECT_EQ(s["lost_frames"], 2);
    EXPECT_NEAR(s["failure_rate"].get<double>(), 5.0 / 26.0, 1e-12);
    EXPECT_EQ(s["loss_events"], 1);
    EXPECT_EQ(s["silent_failures"], 4);
    EXPECT_NEAR(s["reacquire_frames"]["mean"].get<double>(), 5.0, 1e-12);
    EXPECT_NEAR(s["symmetric_2d_px"]["max"].get<double>(), 9.0, 1e-12);
}

}  // namespace
}  // namespace atropos::experiments
