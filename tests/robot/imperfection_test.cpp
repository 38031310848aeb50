#include "robot/imperfection.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <type_traits>

#include "robot/robot_arm.hpp"

namespace atropos::robot {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using scenes::ArmAccuracy;

static_assert(!std::is_convertible_v<True<ArmState>, Measured<ArmState>>);
static_assert(!std::is_convertible_v<Measured<ArmState>, True<ArmState>>);

// A pose near the target that the arm reaches with a wrist bent by up to 45 degrees.
Joints working_joints(const Psm& psm, scenes::RandomStream& random) {
    Joints q;
    for (int i = 0; i < 2; ++i) q[i] = random.uniform(-0.13, 0.13);
    q[2] = random.uniform(0.175, 0.225);
    for (int i = 3; i < 6; ++i) q[i] = random.uniform(-0.8, 0.8);
    EXPECT_LT(psm.limits().first_outside(q), 0);
    return q;
}

// Squared differences between measured and true, over seeds, arms and poses.
struct Figures {
    double tip = 0.0, blade = 0.0, hand_eye = 0.0;
    Joints joints = Joints::Zero();
    int count = 0;
    double rms(double sum) const { return std::sqrt(sum / count); }
};

Figures figures(ArmAccuracy accuracy, int seeds) {
    const Imperfection imperfection = Imperfection::of(accuracy);
    const Layout layout = default_layout();
    const FrameTree tree = frame_tree(layout, scenes::rig_preset("paper").rig);
    const Psm psm(tool("ROUND_TIP_SCISSORS"));
    Figures f;
    for (int seed = 0; seed < seeds; ++seed)
        for (const ArmPlacement& arm : layout.arms) {
            const auto s = static_cast<std::uint64_t>(seed);
            const Isometry3d X_CB = tree.pose("C", arm.name + "_base");
            const Vector3d p_CW = tree.pose("C", "W").translation();
            const Isometry3d believed = registered(X_CB, p_CW, imperfection, s, arm.name);
            scenes::RandomStream random(s, "test." + arm.name);
            Setpoint from;
            from.q = working_joints(psm, random);
            ImperfectDrive drive(imperfection, s, arm.name, from);
            for (int pose = 0; pose < 10; ++pose) {
                Setpoint to;
                to.q = working_joints(psm, random);
                for (int i = 1; i <= 150; ++i) {
                    Setpoint now;
                    now.q = from.q + (to.q - from.q) * std::min(1.0, i / 100.0);
                    drive.step(now);
                }
                from = to;
                const Joints measured = drive.read().value, truth = drive.true_joints().value;
                const Isometry3d X_measured = believed * psm.forward(measured),
                                 X_true = X_CB * psm.forward(truth);
                const Isometry3d X_TS = *psm.tool().X_TS;
                f.tip += (X_measured.translation() - X_true.translation()).squaredNorm();
                f.blade += ((X_measured * X_TS).translation() - (X_true * X_TS).translation()).squaredNorm();
                f.hand_eye +=
                    (X_measured.translation() - (X_CB * psm.forward(measured)).translation()).squaredNorm();
                f.joints += (measured - truth).cwiseAbs2();
                ++f.count;
            }
        }
    std::printf("accuracy %d: tip %.2f mm, blade %.2f mm, hand-eye %.2f mm RMS; joints RMS",
                static_cast<int>(accuracy), 1e3 * f.rms(f.tip), 1e3 * f.rms(f.blade),
                1e3 * f.rms(f.hand_eye));
    for (int i = 0; i < 6; ++i)
        std::printf(i == 2 ? " %.2f mm" : " %.2f deg", f.rms(f.joints[i]) * (i == 2 ? 1e3 : 57.29578));
    std::printf("\n");
    return f;
}

TEST(Imperfection, calibrated_arms_are_off_by_1_9_mm_with_hand_eye_1_0) {
    const Figures f = figures(ArmAccuracy::kCalibrated, 100);
    EXPECT_NEAR(1e3 * f.rms(f.tip), 1.9, 0.19);
    EXPECT_NEAR(1e3 * f.rms(f.hand_eye), 1.0, 0.1);
}

TEST(Imperfection, uncalibrated_arms_are_off_by_4_mm) {
    const Figures f = figures(ArmAccuracy::kUncalibrated, 100);
    EXPECT_NEAR(1e3 * f.rms(f.tip), 4.0, 0.4);
}

TEST(Imperfection, recorded_arms_have_the_recorded_joint_errors_and_no_hand_eye_error) {
    const Figures f = figures(ArmAccuracy::kAsRecorded, 100);
    EXPECT_EQ(f.hand_eye, 0.0);
    const double expected[6] = {0.09, 0.08, 0.39, 9.5, 10.9, 15.1};
    for (int i = 0; i < 6; ++i)
        EXPECT_NEAR(f.rms(f.joints[i]) * (i == 2 ? 1e3 : 57.29578), expected[i], 0.1 * expected[i]) << i;
}

TEST(Imperfection, perfect_arms_are_exact) {
    const Layout layout = default_layout();
    const FrameTree tree = frame_tree(layout, scenes::rig_preset("paper").rig);
    Joints q;
    q << 0.1, 0.1, 0.2, 0.3, 0.2, 0.1;
    RobotArm arm(layout.arms[0], tree, q, 0.3, Imperfection::of(ArmAccuracy::kPerfect), 1);
    EXPECT_TRUE(arm.controller().move_jr(Joints::Constant(0.01)));
    for (int i = 0; i < 100; ++i) {
        arm.step();
        EXPECT_EQ(arm.truth().value.q, arm.controller().setpoint().q);
        EXPECT_EQ(arm.measured().value.q, arm.truth().value.q);
        EXPECT_EQ(arm.measured().value.X_CT.matrix(), arm.truth().value.X_CT.matrix());
        EXPECT_EQ(arm.measured().value.time_s, arm.time_s());
    }
}

TEST(Imperfection, the_same_seed_gives_the_same_arm_and_another_seed_another) {
    const Layout layout = default_layout();
    const FrameTree tree = frame_tree(layout, scenes::rig_preset("paper").rig);
    Joints q;
    q << 0.1, 0.1, 0.2, 0.3, 0.2, 0.1;
    const auto run = [&](std::uint64_t seed) {
        RobotArm arm(layout.arms[0], tree, q, 0.3, Imperfection::of(ArmAccuracy::kCalibrated), seed);
        EXPECT_TRUE(arm.controller().move_jr(Joints::Constant(0.02)));
        for (int i = 0; i < 300; ++i) arm.step();
        return arm;
    };
    const RobotArm a = run(1), b = run(1), c = run(2);
    EXPECT_EQ(a.truth().value.X_CT.matrix(), b.truth().value.X_CT.matrix());
    EXPECT_EQ(a.measured().value.X_CT.matrix(), b.measured().value.X_CT.matrix());
    EXPECT_NE(a.truth().value.X_CT.matrix(), c.truth().value.X_CT.matrix());
}

TEST(Imperfection, measurements_arrive_late_in_order_and_at_their_rate) {
    const Layout layout = default_layout();
    const FrameTree tree = frame_tree(layout, scenes::rig_preset("paper").rig);
    Imperfection imperfection;
    imperfection.publish_period_s = 0.010;
    imperfection.latency_s = 0.020;
    imperfection.jitter_s = 0.015;
    Joints q;
    q << 0.1, 0.1, 0.2, 0.3, 0.2, 0.1;
    RobotArm arm(layout.arms[0], tree, q, 0.3, imperfection, 1);
    double last = 0.0, least = 1.0, most = 0.0;
    for (int i = 0; i < 2000; ++i) {
        arm.step();
        const double stamp = arm.measured().value.time_s;
        EXPECT_GE(stamp, last);
        if (stamp > last) {
            EXPECT_NEAR(std::remainder(stamp, 0.010), 0.0, 1e-12);
            least = std::min(least, arm.time_s() - stamp);
            most = std::max(most, arm.time_s() - stamp);
        }
        last = stamp;
    }
    EXPECT_GE(least, 0.020 - 1e-9);
    EXPECT_LE(most, 0.036);
    EXPECT_GT(most, 0.030);
}

TEST(Imperfection, at_rest_the_encoders_miss_the_goal_by_no_more_than_the_stiction) {
    const Layout layout = default_layout();
    const FrameTree tree = frame_tree(layout, scenes::rig_preset("paper").rig);
    const Imperfection imperfection = Imperfection::of(ArmAccuracy::kCalibrated);
    Joints q;
    q << 0.1, 0.1, 0.2, 0.3, 0.2, 0.1;
    RobotArm arm(layout.arms[0], tree, q, 0.3, imperfection, 1);
    ASSERT_TRUE(arm.controller().move_jr(Joints::Constant(0.02)));
    for (int i = 0; i < 2000; ++i) arm.step();
    const Joints missing = arm.steady_state_error().value;
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(missing[i], imperfection.stiction[i], 1e-9);
}

TEST(Play, output_stands_in_the_gap_and_follows_behind_it) {
    Play play(0.1, 0.0);
    EXPECT_EQ(play.follow(0.05), 0.0);
    EXPECT_NEAR(play.follow(0.3), 0.2, 1e-15);
    EXPECT_NEAR(play.follow(0.15), 0.2, 1e-15);
    EXPECT_NEAR(play.follow(0.0), 0.1, 1e-15);
}

}  // namespace
}  // namespace atropos::robot
