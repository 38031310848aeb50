#include "robot/manipulation.hpp"

#include <gtest/gtest.h>

#include "robot/motion_script.hpp"
#include "tests/robot/default_arms.hpp"
#include "tests/robot/hanging_thread.hpp"

namespace atropos::robot {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// Steps the two holders through a manipulation and tells the mean speed of the point between the true grips.
struct Trial {
    double mean_speed_m_s = 0.0, worst_lag_m = 0.0, least_clearance_m = 1.0;
};
Trial run(const ManipulationOptions& options, std::uint64_t seed, int steps) {
    const DefaultArms scene;
    ArmTeam team = scene.team();
    const Manipulation motion(scene.X_CG(), options, seed);
    Trial r;
    Vector3d before = Vector3d::Zero();
    int counted = 0;
    for (int k = 1; k <= steps; ++k) {
        const auto X_CG = motion.at(k * PsmArm::kPeriod_s);
        Vector3d middle = Vector3d::Zero();
        for (size_t i = 0; i < 2; ++i) {
            RobotArm& arm = team.arms()[i];
            const auto result =
                arm.controller().servo_cp(arm.command(X_CG[i] * arm.psm().tool().X_TG.inverse()));
            EXPECT_TRUE(result) << result.reason;
            if (!result) return r;
        }
        team.step();
        for (size_t i = 0; i < 2; ++i) {
            const RobotArm& arm = team.arms()[i];
            const Vector3d p_CG = (arm.truth().value.X_CT * arm.psm().tool().X_TG).translation();
            r.worst_lag_m = std::max(r.worst_lag_m, (p_CG - X_CG[i].translation()).norm());
            middle += 0.5 * p_CG;
        }
        if (k > 1500) {
            r.mean_speed_m_s += (middle - before).norm() / PsmArm::kPeriod_s;
            ++counted;
        }
        before = middle;
        if (k % 20 == 0) r.least_clearance_m = std::min(r.least_clearance_m, team.clearance_m());
    }
    EXPECT_EQ(team.stops(), 0) << team.warning();
    r.mean_speed_m_s /= counted;
    return r;
}

TEST(Manipulation, starts_at_rest_at_the_given_grips) {
    const DefaultArms scene;
    const Manipulation motion(scene.X_CG(), {}, 1);
    for (size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(motion.at(0.0)[i].matrix(), scene.X_CG()[i].matrix());
        EXPECT_LT((motion.at(1e-3)[i].translation() - scene.X_CG()[i].translation()).norm(), 1e-8);
    }
}

TEST(Manipulation, keeps_the_thread_slack_in_view_and_above_the_tissue_for_every_seed) {
    const DefaultArms scene;
    const Isometry3d X_WC = scene.tree.pose("W", "C");
    double shortest = 1.0, longest = 0.0, lowest = 1.0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        const Manipulation motion(scene.X_CG(), {}, seed);
        for (double t = 0.0; t < 20.0; t += 0.1) {
            const auto X_CG = motion.at(t);
            const double span = (X_CG[1].translation() - X_CG[0].translation()).norm() / 0.07;
            shortest = std::min(shortest, span);
            longest = std::max(longest, span);
            const auto thread =
                hanging_thread(X_WC * X_CG[0].translation(), X_WC * X_CG[1].translation(), 0.07);
            for (size_t i = 0; i < thread.points.size(); i += 5) {
                const Vector3d p_C = X_WC.inverse() * thread.points[i];
                EXPECT_TRUE(scene.rig.left.contains(scene.rig.project_left(p_C))) << seed << " " << t;
                EXPECT_TRUE(scene.rig.right.contains(scene.rig.project_right(p_C))) << seed << " " << t;
                lowest = std::min(lowest, thread.points[i].z());
            }
        }
    }
    EXPECT_GE(shortest, 0.62);
    EXPECT_LE(longest, 0.82);
    EXPECT_GT(lowest, -0.025);
    std::printf("span %.3f to %.3f of the length, lowest point %.1f mm\n", shortest, longest, 1e3 * lowest);
}

TEST(Manipulation, arms_follow_it_at_the_speed_asked_for_without_lag) {
    for (const double speed : {0.015, 0.05}) {
        ManipulationOptions options;
        options.speed_m_s = speed;
        const Trial r = run(options, 3, 10000);
        EXPECT_NEAR(r.mean_speed_m_s, speed, 0.1 * speed);
        EXPECT_LT(r.worst_lag_m, 5e-5);
        EXPECT_GT(r.least_clearance_m, 0.005);
        std::printf("asked %.0f mm/s: %.1f mm/s, lag %.4f mm, %.1f mm clear\n", 1e3 * speed,
                    1e3 * r.mean_speed_m_s, 1e3 * r.worst_lag_m, 1e3 * r.least_clearance_m);
    }
}

TEST(Manipulation, a_time_scale_makes_the_same_motion_faster) {
    const DefaultArms scene;
    ManipulationOptions fast;
    fast.time_scale = 3.0;
    const Manipulation slow(scene.X_CG(), {}, 5), thrice(scene.X_CG(), fast, 5);
    for (double t = 0.0; t < 5.0; t += 0.13)
        for (size_t i = 0; i < 2; ++i)
            EXPECT_LT((slow.at(3.0 * t)[i].matrix() - thrice.at(t)[i].matrix()).norm(), 1e-12);
    EXPECT_NEAR(run(fast, 5, 3333).mean_speed_m_s, 0.045, 0.009);
}

TEST(Manipulation, tremor_has_its_amplitude_and_frequency_and_changes_nothing_else) {
    const DefaultArms scene;
    ManipulationOptions options;
    options.tremor_rms_m = 3e-5;
    const Manipulation calm(scene.X_CG(), {}, 6), shaking(scene.X_CG(), options, 6);
    double sum = 0.0, before = 0.0;
    int crossings = 0, count = 0;
    for (double t = 2.0; t < 12.0; t += 1e-3, ++count) {
        const double d = (shaking.at(t)[0].translation() - calm.at(t)[0].translation()).x();
        sum += d * d;
        crossings += (d > 0) != (before > 0);
        before = d;
    }
    EXPECT_NEAR(std::sqrt(sum / count), 3e-5, 0.4e-5);
    EXPECT_NEAR(crossings / 20.0, 10.0, 2.0);
    EXPECT_LT(run(options, 6, 3000).worst_lag_m, 1e-4);
}

TEST(Manipulation, grips_too_far_apart_are_refused) {
    DefaultArms scene;
    scene.defaults.grip_distance_m = 0.068;
    EXPECT_THROW(Manipulation(scene.X_CG(), {}, 1), std::invalid_argument);
}

TEST(MotionScript, the_third_arm_grasps_in_the_middle) {
    DefaultArms scene;
    scene.layout.arms[2].tool = "PROGRASP_FORCEPS";
    const Psm psm(tool("PROGRASP_FORCEPS"));
    const Vector3d p_WB = scene.layout.arms[2].X_WB.translation();
    const auto q =
        joints_for(psm, scene.layout.arms[2].X_WB, scene.defaults.X_WS_parked(p_WB), psm.tool().X_TG);
    ASSERT_TRUE(q);
    RobotArm arm(scene.layout.arms[2], scene.tree, q.q, 0.0, {}, 1);
    const Isometry3d X_CG =
        scene.tree.pose("C", "W") * LayoutDefaults::X_WS({0, 0, -0.01}, Vector3d::UnitX(), p_WB);
    ScriptRunner runner(grasp_script(psm.tool(), X_CG, 0.02, 0.005), arm);
    double closed_at_m = 1.0;
    for (int i = 0; i < 20000 && !runner.is_done(); ++i) {
        runner.step();
        arm.step();
        if (arm.truth().value.jaw_rad > 0.3)
            closed_at_m =
                ((arm.truth().value.X_CT * psm.tool().X_TG).translation() - X_CG.translation()).norm();
    }
    EXPECT_TRUE(runner.is_done());
    EXPECT_EQ(runner.failure(), "");
    EXPECT_LT(closed_at_m, 1e-8);
    EXPECT_NEAR(((arm.truth().value.X_CT * psm.tool().X_TG).translation() - X_CG.translation()).norm(), 0.005,
                1e-8);
    EXPECT_LT(arm.truth().value.jaw_rad, 0.0);
}

TEST(MotionScript, two_arms_pull_a_knot_apart_and_faster_means_faster) {
    const DefaultArms scene;
    std::array<double, 2> duration{};
    for (int fast = 0; fast < 2; ++fast) {
        ArmTeam team = scene.team();
        std::vector<ScriptRunner> runners;
        for (size_t i = 0; i < 2; ++i) {
            const MotionScript script = pull_script(team.arms()[i].psm().tool(), scene.X_CG()[i],
                                                    Vector3d(i == 0 ? 1 : -1, 0, 0), 0.008);
            runners.emplace_back(fast ? script.faster(2.0) : script, team.arms()[i]);
        }
        int steps = 0;
        for (; steps < 10000 && !(runners[0].is_done() && runners[1].is_done()); ++steps) {
            for (auto& runner : runners) runner.step();
            team.step();
        }
        for (size_t i = 0; i < 2; ++i) {
            EXPECT_EQ(runners[i].failure(), "");
            const auto& arm = team.arms()[i];
            EXPECT_NEAR(((arm.truth().value.X_CT * arm.psm().tool().X_TG).translation() -
                         scene.X_CG()[i].translation())
                            .norm(),
                        0.008, 1e-8);
        }
        duration[static_cast<size_t>(fast)] = steps;
    }
    EXPECT_NEAR(duration[0] / duration[1], 2.0, 0.1);
}

TEST(MotionScript, a_refused_step_ends_the_script_with_its_reason) {
    const DefaultArms scene;
    RobotArm arm = scene.make(0);
    Isometry3d far = scene.X_CG()[0];
    far.translation().z() += 0.3;
    ScriptRunner runner(MotionScript(arm.psm().tool().X_TG).through({far}), arm);
    runner.step();
    EXPECT_TRUE(runner.is_done());
    EXPECT_NE(runner.failure().find("step 0: insertion"), std::string::npos) << runner.failure();
}

TEST(ArmTeam, a_planned_move_into_another_arm_is_refused_with_its_name) {
    const DefaultArms scene;
    ArmTeam team = scene.team();
    const Psm& psm = team.arm("PSM3").psm();
    Isometry3d X_WS = LayoutDefaults::X_WS({-0.025, 0.0, 0.012}, Vector3d::UnitX(),
                                           scene.layout.arms[2].X_WB.translation());
    const auto q = joints_for(psm, scene.layout.arms[2].X_WB, X_WS, *psm.tool().X_TS, scene.start(2));
    ASSERT_TRUE(q);
    const auto result = team.move_jp("PSM3", q.q);
    EXPECT_FALSE(result);
    EXPECT_NE(result.reason.find("PSM1"), std::string::npos) << result.reason;
    EXPECT_EQ(team.arm("PSM3").controller().goal(), scene.start(2));
    EXPECT_THROW(team.arm("PSM4"), std::invalid_argument);
}

TEST(ArmTeam, arms_driven_at_each_other_stop_before_they_touch) {
    const DefaultArms scene;
    ArmTeam team = scene.team();
    RobotArm& arm = team.arm("PSM3");
    const Vector3d towards =
        Vector3d(-0.025, 0.0, 0.012) -
        scene.defaults.park_distance_m * scene.layout.arms[2].X_WB.translation().normalized();
    Twist V = Twist::Zero();
    V.head<3>() = scene.layout.arms[2].X_WB.linear().transpose() * towards.normalized() * 0.2;
    double least = 1.0;
    for (int i = 0; i < 3000; ++i) {
        EXPECT_TRUE(arm.controller().servo_cv(V));  // again and again: the guard must win
        team.step();
        least = std::min(least, team.clearance_m());
    }
    EXPECT_GT(team.stops(), 0);
    EXPECT_NE(team.warning().find("PSM"), std::string::npos);
    EXPECT_GT(least, 0.0019);
    EXPECT_LT(least, 0.003);
    std::printf("driven at each other: %.2f mm clear\n", 1e3 * least);
    V = -V;  // the way back is open
    for (int i = 0; i < 500; ++i) {
        EXPECT_TRUE(arm.controller().servo_cv(V));
        team.step();
    }
    EXPECT_GT(team.clearance_m(), 0.02);
}

}  // namespace
}  // namespace atropos::robot
