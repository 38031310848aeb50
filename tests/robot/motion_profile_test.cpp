#include "robot/motion_profile.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "robot/joint_servo.hpp"
#include "scenes/random_stream.hpp"

namespace atropos::robot {
namespace {

constexpr double kStep = 1e-3;

TEST(MotionProfile, a_rest_to_rest_motion_takes_the_textbook_time) {
    // Long enough to reach all limits: T = distance / v + v / a + a / j (Biagiotti and Melchiorri 2008, 3.4).
    const MotionLimits limits{0.5, 2.0, 20.0};
    const auto profile = MotionProfile::to_rest_at({}, 1.0, limits);
    EXPECT_NEAR(profile.duration_s(), 1.0 / 0.5 + 0.5 / 2.0 + 2.0 / 20.0, 1e-12);
    // Short: neither velocity nor acceleration limit is reached, T = 4 cbrt(distance / (2 j)).
    const auto small = MotionProfile::to_rest_at({}, 1e-3, limits);
    EXPECT_NEAR(small.duration_s(), 4.0 * std::cbrt(1e-3 / (2 * 20.0)), 1e-9);
}

TEST(MotionProfile, arrives_at_rest_from_any_state_within_the_limits) {
    scenes::RandomStream random(1, "profiles");
    for (int n = 0; n < 20000; ++n) {
        const MotionLimits limits{random.uniform(0.1, 2), random.uniform(0.1, 10), random.uniform(1, 200)};
        MotionState start{random.uniform(-1, 1), 0.0, random.uniform(-1, 1) * limits.acceleration};
        // The velocity when the acceleration runs out must lie inside the limits as well.
        const double coast = 0.5 * start.acceleration * std::abs(start.acceleration) / limits.jerk;
        start.velocity = random.uniform(-1, 1) * limits.velocity - coast;
        if (std::abs(start.velocity) > limits.velocity) continue;
        const double target = random.uniform(-1, 1);
        const auto profile = MotionProfile::to_rest_at(start, target, limits);
        const MotionState end = profile.at(profile.duration_s());
        EXPECT_NEAR(end.position, target, 1e-9);
        EXPECT_NEAR(end.velocity, 0.0, 1e-9);
        EXPECT_NEAR(end.acceleration, 0.0, 1e-7);
        const auto extent = profile.extent();
        for (int i = 0; i <= 100; ++i) {
            const MotionState s = profile.at(profile.duration_s() * i / 100);
            EXPECT_LE(std::abs(s.velocity), limits.velocity * (1 + 1e-9));
            EXPECT_LE(std::abs(s.acceleration), limits.acceleration * (1 + 1e-9));
            EXPECT_GE(s.position, extent.lowest - 1e-12);
            EXPECT_LE(s.position, extent.highest + 1e-12);
        }
    }
}

TEST(JointServo, keeps_every_limit_in_ten_minutes_of_random_targets) {
    const MotionLimits limits{5.0, 20.0, 400.0};
    JointServo servo(limits, -0.9, 0.9, 0.0);
    scenes::RandomStream random(2, "targets");
    double target = 0.0, velocity = 0.0, acceleration = 0.0, previous_acceleration = 0.0, worst_jerk = 0.0;
    for (int i = 0; i < 600'000; ++i) {
        if (random.integer(50) == 0) target = random.uniform(-0.9, 0.9);     // jumps
        if (random.integer(200) == 0) velocity = random.uniform(-6.0, 6.0);  // and streams, too fast at times
        if (random.integer(20) == 0) velocity = 0.0;
        if (random.integer(30) == 0) acceleration = random.uniform(-25.0, 25.0);
        if (random.integer(5) == 0) acceleration = 0.0;
        target = std::clamp(target + velocity * kStep, -0.9, 0.9);
        servo.follow({target, velocity, acceleration}, kStep);
        const MotionState& s = servo.state();
        ASSERT_LE(std::abs(s.velocity), limits.velocity * (1 + 1e-9)) << i;
        ASSERT_LE(std::abs(s.acceleration), limits.acceleration * (1 + 1e-9)) << i;
        ASSERT_LE(std::abs(s.position), 0.9 + 1e-9) << i;
        worst_jerk = std::max(worst_jerk, std::abs(s.acceleration - previous_acceleration) / kStep);
        previous_acceleration = s.acceleration;
    }
    EXPECT_LE(worst_jerk, limits.jerk * (1 + 1e-6));
    EXPECT_GE(worst_jerk, 0.9 * limits.jerk);  // and uses what it may
}

TEST(JointServo, follows_a_smooth_target_without_lag) {
    JointServo servo({5.0, 20.0, 400.0}, -2.0, 2.0, 0.0);
    double worst = 0.0, before = 0.0, velocity_before = 0.0;
    for (int i = 1; i <= 5000; ++i) {
        const double t = i * kStep, ramp = std::min(1.0, t * t);
        const double target = 0.1 * ramp * std::sin(2 * 3.14159 * 1.0 * t);
        const double velocity = (target - before) / kStep;
        servo.follow({target, velocity, (velocity - velocity_before) / kStep}, kStep);
        before = target;
        velocity_before = velocity;
        if (i > 1500) worst = std::max(worst, std::abs(servo.state().position - target));
    }
    EXPECT_LT(worst, 2e-5);
}

TEST(JointServo, comes_to_rest_exactly_on_its_target) {
    JointServo servo({5.0, 20.0, 400.0}, -2.0, 2.0, 0.0);
    for (int i = 0; i < 2000; ++i) servo.follow({0.7, 0.0, 0.0}, kStep);
    EXPECT_EQ(servo.state().position, 0.7);
    EXPECT_TRUE(servo.at_rest());
}

}  // namespace
}  // namespace atropos::robot
