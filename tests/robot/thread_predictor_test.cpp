#include "robot/thread_predictor.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace atropos::robot {
namespace {

using Eigen::Vector3d;

constexpr double kLatency_s = 0.01, kFrame_s = 1.0 / 30.0;

/// A thread between two grips that come and go as in the fast scene; its middle rises when they part.
struct Thread {
    Vector3d grip(size_t end, double t) const {
        const double side = end == 0 ? -1.0 : 1.0;
        return Vector3d(side * (0.025 + half_spread(t)), 0.0, 0.100) +
               Vector3d(0.012 * std::sin(3.0 * t), 0.008 * std::sin(4.0 * t), 0.0);
    }
    Vector3d middle(double t) const {
        return 0.5 * (grip(0, t) + grip(1, t)) + Vector3d(0.0, 0.016 - 1.6 * half_spread(t), 0.0);
    }
    static double half_spread(double t) { return 0.003 * std::sin(5.0 * t); }

    scenes::ThreadEstimate seen(double t) const {
        scenes::ThreadEstimate estimate;
        estimate.capture_time_s = t;
        estimate.status = scenes::TrackStatus::kTracking;
        estimate.confidence = 1.0;
        const Vector3d a = grip(0, t), b = grip(1, t), bulge = middle(t) - 0.5 * (a + b);
        double s_m = 0.0;
        for (int i = 0; i <= 100; ++i) {
            const double u = 0.01 * i;
            const Vector3d p = (1.0 - u) * a + u * b + 4.0 * u * (1.0 - u) * bulge;
            if (i > 0) s_m += (p - estimate.samples.back().p_C).norm();
            estimate.samples.push_back({s_m, p, 1e-4, 3e-4});
        }
        return estimate;
    }
};

ScissorsInput input(const Thread& thread, const ScissorsOptions& options, double t) {
    ScissorsInput input;
    input.time_s = t;
    for (size_t end : {0, 1}) {
        ArmState state;
        state.time_s = t;
        state.X_CT.translation() = thread.grip(end, t) - options.X_TG[end].translation();
        input.holders[end] = Measured<ArmState>{state};
    }
    return input;
}

/// RMS errors of what is predicted for now, from the fourth second on.
struct Errors {
    double place_m = 0.0, velocity_m_s = 0.0;
};

Errors follow(double until_s) {
    const Thread thread;
    const ScissorsOptions options;
    ThreadPredictor predictor(options);
    Errors sum;
    int count = 0, frame = 0;
    for (int tick = 0; tick < std::lround(1e3 * until_s); ++tick) {
        const double t = 1e-3 * tick;
        predictor.observe_grips(input(thread, options, t));
        if (t >= frame * kFrame_s + kLatency_s) {
            predictor.observe(thread.seen(frame * kFrame_s));
            ++frame;
        }
        if (t < 4.0) continue;
        const ThreadPrediction now = predictor.at(t);
        const Vector3d v = (thread.middle(t + 1e-4) - thread.middle(t - 1e-4)) / 2e-4;
        sum.place_m += (now.p_C - thread.middle(t)).squaredNorm();
        sum.velocity_m_s += (now.v_C - v).squaredNorm();
        ++count;
    }
    return {std::sqrt(sum.place_m / count), std::sqrt(sum.velocity_m_s / count)};
}

TEST(ThreadPredictor, knows_the_middle_now_from_late_estimates_and_measured_grips) {
    EXPECT_LT(follow(10.0).place_m, 0.0003);
}

TEST(ThreadPredictor, knows_how_fast_the_middle_moves_when_the_grips_part) {
    // The grips' own mean moves at 45 mm/s, their parting lifts the middle at up to 24 mm/s more.
    EXPECT_LT(follow(10.0).velocity_m_s, 0.006);
}

}  // namespace
}  // namespace atropos::robot
