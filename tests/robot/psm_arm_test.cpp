#include "robot/psm_arm.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/robot/random_joints.hpp"

namespace atropos::robot {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Joints middle() {
    Joints q;
    q << 0.1, -0.1, 0.15, 0.3, 0.2, -0.1;
    return q;
}

PsmArm arm() {
    return PsmArm(Psm(tool("LARGE_NEEDLE_DRIVER")), middle());
}

Isometry3d shifted(Isometry3d X, const Vector3d& by) {
    X.translation() += by;
    return X;
}

// Watches set-points and remembers how far velocity, acceleration and jerk came, as shares of their limits.
struct Watch {
    const ArmLimits limits;
    Setpoint before{};
    std::array<double, 7> acceleration{};
    double velocity_share = 0.0, acceleration_share = 0.0, jerk_share = 0.0;
    int seen = 0;

    void see(const PsmArm& a) {
        const Setpoint s = a.setpoint();
        for (size_t i = 0; i < 7; ++i) {
            const int k = static_cast<int>(i);
            const MotionLimits& limit = i < 6 ? limits.joints[i] : limits.jaw;
            const double v = i < 6 ? s.qd[k] : s.jaw_velocity_rad_s;
            const double v0 = i < 6 ? before.qd[k] : before.jaw_velocity_rad_s;
            const double a_now = (v - v0) / PsmArm::kPeriod_s;
            velocity_share = std::max(velocity_share, std::abs(v) / limit.velocity);
            if (seen > 0)
                acceleration_share = std::max(acceleration_share, std::abs(a_now) / limit.acceleration);
            if (seen > 1)
                jerk_share =
                    std::max(jerk_share, std::abs(a_now - acceleration[i]) / PsmArm::kPeriod_s / limit.jerk);
            acceleration[i] = a_now;
        }
        before = s;
        ++seen;
    }
};

TEST(PsmArm, move_jp_ends_on_its_goal_and_moves_queue_in_order) {
    PsmArm a = arm();
    Joints first = middle(), second = middle();
    first[0] += 0.3;
    second[2] += 0.03;
    ASSERT_TRUE(a.move_jp(first));
    ASSERT_TRUE(a.move_jp(second, 0.5));
    bool passed_first = false;
    for (int i = 0; i < 20000 && a.is_busy(); ++i) {
        a.step();
        passed_first |= a.setpoint().q == first;
    }
    EXPECT_TRUE(passed_first);
    EXPECT_EQ(a.setpoint().q, second);
    EXPECT_EQ(a.setpoint().qd, Joints::Zero());
}

TEST(PsmArm, move_jp_goes_straight_in_joint_space) {
    PsmArm a = arm();
    Joints goal;
    goal << -0.4, 0.3, 0.2, 2.0, -0.8, 0.9;
    ASSERT_TRUE(a.move_jp(goal));
    const Joints way = goal - middle();
    while (a.is_busy()) {
        a.step();
        const Joints done = (a.setpoint().q - middle()).cwiseQuotient(way);
        EXPECT_LT(done.maxCoeff() - done.minCoeff(), 1e-9);
    }
}

TEST(PsmArm, move_line_keeps_to_the_line_within_a_hundredth_of_a_millimetre) {
    PsmArm a = arm();
    const Isometry3d start = a.setpoint_cp();
    Isometry3d goal = shifted(start, {0.02, -0.015, 0.01});
    goal.linear() = goal.linear() * Eigen::AngleAxisd(0.4, Vector3d(1, 2, 0.5).normalized());
    ASSERT_TRUE(a.move_line(goal));
    const Vector3d along = (goal.translation() - start.translation()).normalized();
    double worst = 0.0, fastest = 0.0;
    Vector3d before = start.translation();
    while (a.is_busy()) {
        a.step();
        const Vector3d p = a.setpoint_cp().translation(), d = p - start.translation();
        worst = std::max(worst, (d - d.dot(along) * along).norm());
        fastest = std::max(fastest, (p - before).norm() / PsmArm::kPeriod_s);
        before = p;
    }
    EXPECT_LT(worst, 1e-5);
    EXPECT_LE(fastest, 0.0401);
    EXPECT_GT(fastest, 0.02);
    EXPECT_LT((a.setpoint_cp().matrix() - goal.matrix()).norm(), 1e-9);
}

TEST(PsmArm, way_points_are_passed_within_the_blend_radius_without_stopping) {
    PsmArm a = arm();
    const Isometry3d X = a.setpoint_cp();
    const std::vector<Isometry3d> points = {X, shifted(X, {0.02, 0, 0}), shifted(X, {0.02, 0.02, 0}),
                                            shifted(X, {0.0, 0.02, 0.01})};
    const double blend = 0.004;
    ASSERT_TRUE(a.follow(CartesianPath(points, blend)));
    std::array<double, 4> nearest{1, 1, 1, 1};
    double slowest = 1.0, off_path = 0.0;
    int steps = 0;
    while (a.is_busy()) {
        const Vector3d before = a.setpoint_cp().translation();
        a.step();
        ++steps;
        const Vector3d p = a.setpoint_cp().translation();
        const double speed = (p - before).norm() / PsmArm::kPeriod_s;
        const bool near_ends = (p - points.front().translation()).norm() < 0.006 ||
                               (p - points.back().translation()).norm() < 0.006;
        if (!near_ends) slowest = std::min(slowest, speed);
        double off = 1.0;
        for (size_t i = 0; i < 4; ++i)
            nearest[i] = std::min(nearest[i], (p - points[i].translation()).norm());
        for (size_t i = 0; i + 1 < 4; ++i)
            off = std::min(
                off, scenes::segment_distance(p, p, points[i].translation(), points[i + 1].translation())
                         .distance_m);
        off_path = std::max(off_path, off);
    }
    EXPECT_LT(nearest[1], 0.375 * blend);
    EXPECT_LT(nearest[2], 0.375 * blend);
    EXPECT_LT(off_path, 0.375 * blend);
    EXPECT_GT(slowest, 0.015);
    EXPECT_LT((a.setpoint_cp().translation() - points.back().translation()).norm(), 1e-9);
}

TEST(PsmArm, a_stream_of_poses_is_followed_without_lag) {
    PsmArm a = arm();
    const Isometry3d X = a.setpoint_cp();
    double worst = 0.0;
    for (int i = 0; i < 3000; ++i) {
        const double t = i * PsmArm::kPeriod_s, u = std::min(1.0, t), grow = u * u * (3 - 2 * u);
        const Isometry3d target =
            shifted(X, grow * 0.01 * Vector3d(std::sin(6 * t), std::cos(5 * t) - 1, std::sin(4 * t)));
        ASSERT_TRUE(a.servo_cp(target));
        a.step();
        if (i > 10) worst = std::max(worst, (a.setpoint_cp().translation() - target.translation()).norm());
    }
    EXPECT_LT(worst, 2e-5);
}

TEST(PsmArm, relative_commands_add_to_the_last_goal) {
    PsmArm a = arm();
    Joints dq = Joints::Zero();
    dq[0] = 0.01;
    ASSERT_TRUE(a.servo_jr(dq));
    ASSERT_TRUE(a.servo_jr(dq));
    EXPECT_NEAR(a.goal()[0], middle()[0] + 0.02, 1e-15);
    const Isometry3d X = Psm(tool("LARGE_NEEDLE_DRIVER")).forward(a.goal());
    Isometry3d relative = Isometry3d::Identity();
    relative.translation() = Vector3d(0.001, 0.002, -0.003);
    ASSERT_TRUE(a.servo_cr(relative));
    for (int i = 0; i < 2000; ++i) a.step();
    EXPECT_LT((a.setpoint_cp().translation() - X.translation() - relative.translation()).norm(), 1e-9);
}

TEST(PsmArm, servo_cv_moves_at_its_velocity_and_stops_with_a_warning_at_the_edge_of_the_workspace) {
    PsmArm a = arm();
    Twist V = Twist::Zero();
    V[2] = -0.02;
    ASSERT_TRUE(a.servo_cv(V));
    const double z = a.setpoint_cp().translation().z();
    for (int i = 0; i < 1000; ++i) a.step();
    EXPECT_NEAR(a.setpoint_cp().translation().z(), z - 0.02, 5e-4);
    for (int i = 0; i < 8000; ++i) a.step();
    EXPECT_NE(a.warning().find("insertion"), std::string::npos);
    EXPECT_EQ(a.setpoint().qd, Joints::Zero());
    EXPECT_LE(a.setpoint().q[2], 0.24 + 1e-9);
}

TEST(PsmArm, refused_commands_change_nothing_and_say_why) {
    PsmArm a = arm();
    Joints far = middle();
    far[2] = 0.3;
    EXPECT_NE(a.servo_jp(far).reason.find("insertion 300.0 mm"), std::string::npos);
    EXPECT_FALSE(a.move_jp(far));
    EXPECT_FALSE(a.move_jp(middle(), 0.0));
    EXPECT_FALSE(a.servo_cp(shifted(a.setpoint_cp(), {0, 0, -0.2})));
    EXPECT_FALSE(a.move_line(shifted(a.setpoint_cp(), {0, 0, -0.2})));
    EXPECT_FALSE(a.move_line(a.setpoint_cp()));
    EXPECT_NE(a.jaw_move_jp(2.0).reason.find("expected -40 to 80"), std::string::npos);
    EXPECT_FALSE(a.jaw_servo_jp(std::nan("")));
    far[2] = std::nan("");
    EXPECT_FALSE(a.servo_jp(far));
    const Isometry3d X = a.setpoint_cp();
    EXPECT_NE(a.follow(CartesianPath({shifted(X, {0.001, 0, 0}), shifted(X, {0.01, 0, 0})}))
                  .reason.find("1.000 mm"),
              std::string::npos);
    for (int i = 0; i < 10; ++i) a.step();
    EXPECT_EQ(a.setpoint().q, middle());
    EXPECT_THROW(PsmArm(Psm(tool("LARGE_NEEDLE_DRIVER")), Joints::Constant(9)), std::invalid_argument);
}

TEST(PsmArm, a_path_whose_middle_is_out_of_reach_is_refused_with_the_place) {
    PsmArm a = arm();
    const Isometry3d X = a.setpoint_cp();
    const auto result =
        a.follow(CartesianPath({X, shifted(X, {0, 0, -0.12}), shifted(X, {0.02, 0, 0})}, 0.001));
    EXPECT_FALSE(result);
    EXPECT_NE(result.reason.find("mm of the path"), std::string::npos) << result.reason;
}

TEST(PsmArm, the_jaw_moves_at_the_speed_asked_for) {
    PsmArm a = arm();
    ASSERT_TRUE(a.jaw_move_jp(1.0, 0.1));
    int steps = 0;
    double fastest = 0.0;
    for (; a.is_jaw_busy() && steps < 5000; ++steps) {
        a.step();
        fastest = std::max(fastest, a.setpoint().jaw_velocity_rad_s);
    }
    EXPECT_EQ(a.setpoint().jaw_rad, 1.0);
    EXPECT_NEAR(fastest, 1.2566, 1e-3);
    EXPECT_NEAR(steps * PsmArm::kPeriod_s, 1.0 / 1.2566, 0.05);
}

TEST(PsmArm, limits_hold_in_ten_minutes_of_random_commands) {
    PsmArm a = arm();
    Watch watch{a.limits()};
    scenes::RandomStream random(7, "commands");
    int accepted = 0, refused = 0;
    const auto count = [&](const CommandResult& r) { ++(r ? accepted : refused); };
    for (int i = 0; i < 600'000; ++i) {
        if (random.integer(40) == 0) {
            const Joints q = random_joints(a.psm(), random);
            Isometry3d X = a.psm().forward(a.goal());
            X.translation() += 0.01 * Vector3d(random.normal(), random.normal(), random.normal());
            switch (random.integer(8)) {
                case 0:
                    count(a.servo_jp(q));
                    break;
                case 1:
                    count(a.servo_cp(X));
                    break;
                case 2:
                    count(
                        a.servo_cv(0.3 * Twist::NullaryExpr([&](Eigen::Index) { return random.normal(); })));
                    break;
                case 3:
                    count(a.move_jp(q, random.uniform(0.1, 1.0)));
                    break;
                case 4:
                    count(a.move_cp(X));
                    break;
                case 5:
                    count(a.move_line(X, {0.5, 5.0, 100.0}));
                    break;
                case 6:
                    count(a.jaw_servo_jp(random.uniform(-1.0, 1.6)));
                    break;
                case 7:
                    a.hold();
                    break;
            }
        }
        a.step();
        watch.see(a);
        ASSERT_LT(a.psm().limits().first_outside(a.setpoint().q), 0);
    }
    EXPECT_GT(accepted, 5000);
    EXPECT_GT(refused, 500);
    // Set-points are compared over whole periods; rounding apart, none may pass.
    EXPECT_LE(watch.velocity_share, 1.0 + 1e-6);
    EXPECT_LE(watch.acceleration_share, 1.0 + 1e-6);
    EXPECT_LE(watch.jerk_share, 1.0 + 1e-4);
    EXPECT_GE(watch.jerk_share, 0.9);
    std::printf(
        "10 min of commands: velocity %.4f, acceleration %.4f, jerk %.4f of the limits; %d accepted, %d "
        "refused\n",
        watch.velocity_share, watch.acceleration_share, watch.jerk_share, accepted, refused);
}

}  // namespace
}  // namespace atropos::robot
