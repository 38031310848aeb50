#include "robot/recording.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "robot/reach_report.hpp"
#include "tests/robot/default_arms.hpp"
#include "tests/support/real_data.hpp"

namespace atropos::robot {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

std::string error_of(const std::function<void()>& f) {
    try {
        f();
    } catch (const std::runtime_error& error) {
        return error.what();
    }
    return "no error";
}

std::string error_of_csv(const std::string& text) {
    return error_of([&] {
        std::istringstream in(text);
        read_recording_csv(in, "r.csv");
    });
}

// kinematics.csv of PSM1 waving about its default grip, with poses in the given frame.
std::string wave(const DefaultArms& scene, const std::string& frame, bool joints = false) {
    const Psm psm(tool("LARGE_NEEDLE_DRIVER"));
    std::ostringstream out;
    out.precision(17);
    out << "frame,time_s,arm,frame_id,q1,q2,q3,q4,q5,q6,jaw_rad,x_m,y_m,z_m,qx,qy,qz,qw\n";
    for (int i = 0; i <= 60; ++i) {
        Joints q = scene.start(0);
        q[0] += 0.05 * std::sin(0.2 * i);
        q[3] += 0.2 * std::sin(0.1 * i);
        const Isometry3d X = scene.tree.pose(frame, "PSM1_base") * psm.forward(q);
        const Eigen::Quaterniond r(X.linear());
        out << i << ',' << i / 30.0 << ",PSM1," << frame;
        for (int k = 0; k < 6; ++k) out << ',' << (joints ? q[k] : scene.start(0)[k]);
        out << ",0.1," << X.translation().x() << ',' << X.translation().y() << ',' << X.translation().z()
            << ',' << r.x() << ',' << r.y() << ',' << r.z() << ',' << r.w() << '\n';
    }
    return out.str();
}

Replay replay(const DefaultArms& scene, const std::string& text) {
    std::istringstream in(text);
    const auto recordings = read_recording_csv(in, "r.csv");
    EXPECT_EQ(recordings.size(), 1u);
    return Replay(recordings[0], Psm(tool("LARGE_NEEDLE_DRIVER")), {scene.tree.pose("PSM1_base", "C")},
                  "r.csv");
}

TEST(Recording, camera_ecm_and_base_frames_give_the_same_motion) {
    const DefaultArms scene;
    const Replay in_C = replay(scene, wave(scene, "C")), in_ECM = replay(scene, wave(scene, "ECM")),
                 in_base = replay(scene, wave(scene, "PSM1_base", true));
    EXPECT_NEAR(in_C.duration_s(), 2.0, 1e-12);
    for (double t = 0.0; t <= 2.0; t += 0.01) {
        EXPECT_LT((in_C.joints(t) - in_ECM.joints(t)).norm(), 1e-9);
        EXPECT_LT((in_C.joints(t) - in_base.joints(t)).norm(), 1e-9);
    }
    EXPECT_NEAR(in_C.joints(0.5)[0], scene.start(0)[0] + 0.05 * std::sin(3.0), 1e-9);
}

TEST(Recording, an_arm_follows_it_at_1_khz) {
    const DefaultArms scene;
    const Replay r = replay(scene, wave(scene, "C"));
    RobotArm arm = scene.make(0);
    EXPECT_LT((r.joints(0.0) - scene.start(0)).norm(), 1e-9);
    double worst = 0.0;
    for (int i = 1; i <= 2000; ++i) {
        const double t = i * PsmArm::kPeriod_s;
        ASSERT_TRUE(r.drive(arm.controller(), t));
        arm.step();
        if (i > 200 && i < 1950)
            worst = std::max(worst, (arm.truth().value.q - r.joints(t)).cwiseAbs().maxCoeff());
    }
    EXPECT_LT(worst, 1e-3);
}

TEST(Recording, a_registration_places_it_into_the_scene) {
    const DefaultArms scene;
    std::istringstream in(wave(scene, "C"));
    const auto recordings = read_recording_csv(in, "r.csv");
    ReplayFrames frames{scene.tree.pose("PSM1_base", "C")};
    frames.X_registration.translation() = Vector3d(0.004, 0.0, 0.0);
    const Psm psm(tool("LARGE_NEEDLE_DRIVER"));
    const Replay moved(recordings[0], psm, frames, "r.csv"), plain = replay(scene, wave(scene, "C"));
    const Isometry3d X_CB = scene.tree.pose("C", "PSM1_base");
    EXPECT_LT((X_CB * psm.forward(moved.joints(1.0)).translation() -
               X_CB * psm.forward(plain.joints(1.0)).translation() - Vector3d(0.004, 0, 0))
                  .norm(),
              1e-9);
}

TEST(Recording, values_just_past_a_limit_are_clamped_and_counted_and_others_refused_with_their_row) {
    const auto run = [](double wrist, double insertion) {
        std::ostringstream text;
        text << "q1,q2,q3,q4,q5,q6\n0,0,0.1,0,0,0\n0,0," << insertion << ",0," << wrist << ",0\n";
        std::istringstream in(text.str());
        const auto r = read_recording_csv(in, "r.csv");
        return Replay(r[0], Psm(tool("LARGE_NEEDLE_DRIVER")), {}, "r.csv");
    };
    EXPECT_EQ(run(1.3, 0.1).clamped_values(), 0);
    EXPECT_EQ(run(1.3962634 + 0.009, 0.2409).clamped_values(), 2);
    EXPECT_NEAR(run(1.3962634 + 0.009, 0.2409).joints(1.0)[2], 0.24, 1e-12);
    EXPECT_NE(error_of([&] { run(1.3962634 + 0.011, 0.1); }).find("r.csv:3: wrist_pitch"), std::string::npos);
    EXPECT_NE(error_of([&] { run(0.0, 0.2411); }).find("r.csv:3: insertion"), std::string::npos);
}

TEST(Recording, the_real_recording_replays_with_one_clamped_value) {
    const auto file = support::real_data("dvrk-psm-recording.csv");
    if (!file) GTEST_SKIP() << support::kNoRealData;
    std::ifstream in(*file);
    const auto r = read_recording_csv(in, "dvrk-psm-recording.csv", 100.0);
    ASSERT_EQ(r.size(), 1u);
    EXPECT_EQ(r[0].frame_id, "joints");
    const Replay replay(r[0], Psm(tool("LARGE_NEEDLE_DRIVER")), {}, "dvrk-psm-recording.csv");
    EXPECT_NEAR(replay.duration_s(), 4.99, 1e-9);
    EXPECT_EQ(replay.clamped_values(), 1);
}

TEST(Recording, jigsaws_rows_give_both_arms) {
    std::ostringstream text;
    for (int row = 0; row < 3; ++row) {
        for (int c = 0; c < 38; ++c) text << "0 ";
        for (int arm = 0; arm < 2; ++arm) {
            text << 0.01 * row << " " << 0.1 * arm << " 0.1 1 0 0 0 1 0 0 0 1 ";
            for (int c = 0; c < 6; ++c) text << "0 ";
            text << "0.5 ";
        }
        text << "\n";
    }
    std::istringstream in(text.str());
    const auto arms = read_jigsaws(in, "j.txt");
    ASSERT_EQ(arms.size(), 2u);
    EXPECT_EQ(arms[1].arm, "PSM2");
    EXPECT_EQ(arms[1].frame_id, "ECM");
    EXPECT_EQ(arms[1].size(), 3u);
    EXPECT_NEAR(arms[1].time_s[2], 2 / 30.0, 1e-12);
    EXPECT_LT((arms[1].X_FT[2].translation() - Vector3d(0.02, 0.1, 0.1)).norm(), 1e-12);
    EXPECT_EQ(arms[0].jaw_rad[0], 0.5);
    EXPECT_NE(error_of([] {
                  std::istringstream s("1 2 3\n");
                  read_jigsaws(s, "j.txt");
              }).find("j.txt:1: 3 columns, expected the 76"),
              std::string::npos);
}

TEST(Recording, broken_files_are_refused_in_one_line_that_names_the_place) {
    EXPECT_NE(error_of_csv("").find("r.csv:1: empty"), std::string::npos);
    EXPECT_NE(error_of_csv("a,b\n1,2\n").find("r.csv:1: no arm's motion"), std::string::npos);
    EXPECT_NE(error_of_csv("q1,q2,q3,q4,q5,q6\n").find("no rows"), std::string::npos);
    EXPECT_NE(error_of_csv("q1,q2,q3,q4,q5,q6\n0,0,0.1,0,0\n").find("r.csv:2: 5 columns, expected 6"),
              std::string::npos);
    EXPECT_NE(error_of_csv("q1,q2,q3,q4,q5,q6\n0,0,x,0,0,0\n").find("r.csv:2: 'x', expected a finite number"),
              std::string::npos);
    EXPECT_NE(error_of_csv("q1,q2,q3,q4,q5,q6\n0,0,nan,0,0,0\n").find("r.csv:2"), std::string::npos);
    const std::string pose = "time_s,frame_id,x_m,y_m,z_m,qx,qy,qz,qw\n";
    EXPECT_NE(error_of_csv(pose + "0,C,0,0,0.1,0,0,0,2\n").find("quaternion"), std::string::npos);
    EXPECT_NE(
        error_of_csv(pose + "0,C,0,0,0.1,0,0,0,1\n1,ECM,0,0,0.1,0,0,0,1\n").find("r.csv:3: frame_id changes"),
        std::string::npos);
    const auto play = [&](const std::string& text) {
        std::istringstream in(text);
        const auto r = read_recording_csv(in, "r.csv");
        Replay(r[0], Psm(tool("LARGE_NEEDLE_DRIVER")), {}, "r.csv");
    };
    EXPECT_NE(error_of([&] {
                  play("time_s,q1,q2,q3,q4,q5,q6\n1,0,0,0.1,0,0,0\n1,0,0,0.1,0,0,0\n");
              }).find("r.csv:3: time"),
              std::string::npos);
    EXPECT_NE(error_of([&] { play(pose + "0,moon,0,0,0.1,0,0,0,1\n"); }).find("frame_id 'moon'"),
              std::string::npos);
    EXPECT_NE(error_of([&] { play(pose + "0,PSM1_base,0,0,0.0,0,0,0,1\n"); }).find("r.csv:2"),
              std::string::npos);
}

TEST(ReachReport, the_default_scene_is_within_reach_and_a_far_one_is_not) {
    const auto report = reach_report(default_layout(), {});
    ASSERT_EQ(report.size(), 3u);
    for (const auto& arm : report) {
        EXPECT_NEAR(arm.target_distance_m, 0.2, 1e-12);
        EXPECT_FALSE(arm.needs.empty());
        for (const auto& need : arm.needs) {
            EXPECT_TRUE(need.reachable) << arm.name << " " << need.what << ": " << need.reason;
            EXPECT_GT(need.insertion_left_m, 0.015);
        }
    }
    Layout far = default_layout();
    far.arms[2].X_WB.translation() *= 1.3;
    const std::string text = to_text(reach_report(far, {}));
    EXPECT_NE(text.find("cuts a slack middle: no, insertion"), std::string::npos) << text;
    std::printf("%s", to_text(report).c_str());
}

}  // namespace
}  // namespace atropos::robot
