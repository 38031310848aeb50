#include "robot/layout.hpp"

#include <gtest/gtest.h>

namespace atropos::robot {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

scenes::StereoRig rig() {
    return scenes::rig_preset("paper").rig;
}

TEST(Layout, default_remote_centres_are_those_of_the_simulator_with_psm3_opposite_the_camera) {
    const FrameTree tree = frame_tree(default_layout(), rig());
    const auto centre = [&](const char* frame) { return Vector3d(tree.pose("W", frame).translation()); };
    EXPECT_LT((centre("PSM1_base") - Vector3d(-0.1, 0, 0.1732)).norm(), 1e-4);
    EXPECT_LT((centre("PSM2_base") - Vector3d(0.1, 0, 0.1732)).norm(), 1e-4);
    EXPECT_LT((centre("PSM3_base") - Vector3d(0, -0.1414, 0.1414)).norm(), 1e-4);
    EXPECT_LT((centre("ECM_base") - Vector3d(0, 0.1414, 0.1414)).norm(), 1e-4);
    // The tilts of the simulator's scene file: -30, 30 degrees about y, -45 about x.
    const double angle = 0.5235987755982988;
    const auto turn = [](double a, const Vector3d& axis) {
        return Eigen::AngleAxisd(a, axis).toRotationMatrix();
    };
    EXPECT_LT((tree.pose("W", "PSM1_base").linear() - turn(-angle, Vector3d::UnitY())).norm(), 1e-12);
    EXPECT_LT((tree.pose("W", "PSM2_base").linear() - turn(angle, Vector3d::UnitY())).norm(), 1e-12);
    EXPECT_LT((tree.pose("W", "ECM_base").linear() - turn(-1.5 * angle, Vector3d::UnitX())).norm(), 1e-12);
}

TEST(Layout, the_camera_sees_the_target_in_its_middle_at_the_working_distance) {
    for (const double distance : {0.06, 0.1, 0.14}) {
        const FrameTree tree = frame_tree(default_layout(distance), rig());
        const Vector3d left = tree.pose("C", "W").translation(), right = tree.pose("R", "W").translation();
        EXPECT_LT((left - Vector3d(0.0025, 0, distance)).norm(), 1e-12);
        EXPECT_LT((right - Vector3d(-0.0025, 0, distance)).norm(), 1e-12);
    }
}

TEST(Layout, psm1_is_at_the_right_hand_of_the_picture_and_up_is_up) {
    const FrameTree tree = frame_tree(default_layout(), rig());
    EXPECT_GT((tree.pose("C", "PSM1_base").translation().x()), 0.05);
    EXPECT_LT((tree.pose("C", "PSM2_base").translation().x()), -0.05);
    EXPECT_LT((tree.pose("C", "W") * Vector3d(0, 0, 0.01) - tree.pose("C", "W").translation()).y(), 0.0);
    const FrameTree lab = frame_tree(lab_rig(), rig());
    EXPECT_GT((lab.pose("C", "PSM1_base").translation().x()), 0.1);
}

TEST(Layout, the_lab_rig_has_the_base_poses_of_its_console_file) {
    const FrameTree tree = frame_tree(lab_rig(), rig());
    Eigen::Matrix3d R;
    R << 1, 0, 0, 0, -0.8660, 0.5, 0, -0.5, -0.8660;
    const Isometry3d X_EB1 = tree.pose("ECM_tip", "PSM1_base"), X_EB2 = tree.pose("ECM_tip", "PSM2_base");
    EXPECT_LT((X_EB1.linear() - R).cwiseAbs().maxCoeff(), 1e-4);
    EXPECT_LT((X_EB1.translation() - Vector3d(-0.2, 0, 0)).norm(), 1e-12);
    EXPECT_LT((X_EB2.translation() - Vector3d(0.2, 0, 0)).norm(), 1e-12);
}

TEST(Layout, dvrk_camera_frame_has_x_left_and_y_up) {
    const FrameTree tree = frame_tree(default_layout(), rig());
    const Vector3d p_ECM(0.01, 0.02, 0.1);
    EXPECT_LT((tree.pose("C", "ECM") * p_ECM - Vector3d(-0.01, -0.02, 0.1)).norm(), 1e-15);
}

TEST(FrameTree, every_loop_closes) {
    FrameTree tree = frame_tree(default_layout(), rig());
    Joints q;
    q << 0.1, 0.2, 0.15, 0.5, -0.3, 0.2;
    for (const char* arm : {"PSM1", "PSM2", "PSM3"})
        set_tip(tree, arm, Psm(tool("LARGE_NEEDLE_DRIVER")).forward(q));
    const auto names = tree.names();
    EXPECT_EQ(names.size(), 16u);
    for (const auto& a : names)
        for (const auto& b : names)
            for (const auto& c : names) {
                const Isometry3d loop = tree.pose(a, b) * tree.pose(b, c) * tree.pose(c, a);
                EXPECT_LT((loop.matrix() - Eigen::Matrix4d::Identity()).cwiseAbs().maxCoeff(), 1e-12);
            }
}

TEST(FrameTree, unknown_frames_and_second_parents_are_errors) {
    FrameTree tree;
    EXPECT_THROW(tree.set("a", "nowhere", Isometry3d::Identity()), std::invalid_argument);
    tree.set("a", "W", Isometry3d::Identity());
    tree.set("b", "W", Isometry3d::Identity());
    EXPECT_THROW(tree.set("b", "a", Isometry3d::Identity()), std::invalid_argument);
    EXPECT_THROW(tree.set("W", "a", Isometry3d::Identity()), std::invalid_argument);
    EXPECT_THROW(tree.pose("W", "c"), std::invalid_argument);
}

TEST(Tool, names_are_found_in_either_case_and_with_part_number) {
    EXPECT_EQ(tool("large_needle_driver").part_number, 400006);
    EXPECT_EQ(tool("CURVED_SCISSORS:400178").part_number, 400178);
    EXPECT_THROW(tool("SPOON"), std::invalid_argument);
    for (const Tool& t : tools())
        EXPECT_EQ(t.X_TS.has_value(), t.kind == ToolKind::kScissors || t.part_number == 400296);
}

}  // namespace
}  // namespace atropos::robot
