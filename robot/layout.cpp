#include "robot/layout.hpp"

#include <cmath>
#include <stdexcept>

namespace atropos::robot {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

}  // namespace

const ArmPlacement& Layout::arm(std::string_view name) const {
    std::string known;
    for (const ArmPlacement& a : arms) {
        if (a.name == name) return a;
        known += (known.empty() ? "" : ", ") + a.name;
    }
    throw std::invalid_argument("no arm '" + std::string(name) + "', expected one of " + known);
}

Isometry3d aimed_base(const Vector3d& p_WB, const Vector3d& p_WTarget, const Vector3d& along_y_W) {
    const Vector3d z = (p_WB - p_WTarget).normalized();
    const Vector3d x = along_y_W.cross(z).normalized();
    if (!z.allFinite() || !x.allFinite() || x.norm() < 0.5)
        throw std::invalid_argument("aimed_base: remote centre, target and y direction must not be in line");
    Isometry3d X = Isometry3d::Identity();
    X.linear() << x, z.cross(x), z;
    X.translation() = p_WB;
    return X;
}

Layout default_layout(double working_distance_m) {
    const double distance = 0.2, diagonal = distance * std::sqrt(0.5);
    const Vector3d target = Vector3d::Zero(), y = Vector3d::UnitY();
    Layout layout;
    layout.arms = {
        {"PSM1", aimed_base({-0.1, 0.0, distance * std::sqrt(0.75)}, target, y), "LARGE_NEEDLE_DRIVER"},
        {"PSM2", aimed_base({0.1, 0.0, distance * std::sqrt(0.75)}, target, y), "LARGE_NEEDLE_DRIVER"},
        {"PSM3", aimed_base({0.0, -diagonal, diagonal}, target, y), "ROUND_TIP_SCISSORS"}};
    layout.X_WEcm = aimed_base({0.0, diagonal, diagonal}, target, y);
    const auto ecm = Ecm().inverse(Vector3d(0.0, 0.0, working_distance_m - distance));
    if (!ecm) throw std::invalid_argument("default_layout: working distance out of reach: " + reason(ecm));
    layout.ecm_joints = ecm.q;
    return layout;
}

Layout lab_rig() {
    Eigen::Matrix3d R_EB;
    const double c = std::sqrt(0.75);
    R_EB << 1.0, 0.0, 0.0, 0.0, -c, 0.5, 0.0, -0.5, -c;
    const Vector3d p_EW(0.0, 0.0, 0.1);
    Layout layout;
    layout.X_WE = Isometry3d::Identity();
    layout.X_WE->linear() = R_EB.transpose();
    layout.X_WE->translation() = -(R_EB.transpose() * p_EW);
    for (const double side : {-1.0, 1.0}) {
        ArmPlacement arm;
        arm.name = side < 0.0 ? "PSM1" : "PSM2";
        arm.X_WB.translation() = *layout.X_WE * Vector3d(0.2 * side, 0.0, 0.0);
        layout.arms.push_back(arm);
    }
    return layout;
}

Isometry3d half_turn_about_z() {
    Isometry3d X = Isometry3d::Identity();
    X.linear() = Eigen::Vector3d(-1.0, -1.0, 1.0).asDiagonal();
    return X;
}

FrameTree frame_tree(const Layout& layout, const scenes::StereoRig& rig) {
    FrameTree tree;
    for (const ArmPlacement& arm : layout.arms) {
        const Tool& t = tool(arm.tool);
        tree.set(arm.name + "_base", "W", arm.X_WB);
        tree.set(arm.name + "_tip", arm.name + "_base", Psm(t).forward(Joints::Zero()));
        tree.set(arm.name + "_grip", arm.name + "_tip", t.X_TG);
        if (t.X_TS) tree.set(arm.name + "_blade", arm.name + "_tip", *t.X_TS);
    }
    if (layout.X_WE) {
        tree.set("ECM_tip", "W", *layout.X_WE);
    } else {
        tree.set("ECM_base", "W", layout.X_WEcm);
        tree.set("ECM_tip", "ECM_base", Ecm().forward(layout.ecm_joints));
    }
    // The eyes stand to both sides of the tip: C half a baseline to the left, which is +x of dVRK's frame.
    const Vector3d p_CR = rig.X_RC.inverse().translation();
    Isometry3d X_TC = half_turn_about_z();
    X_TC.translation() = X_TC.linear() * (-0.5 * p_CR);
    tree.set("C", "ECM_tip", X_TC);
    tree.set("R", "C", rig.X_RC.inverse());
    tree.set("ECM", "C", half_turn_about_z());
    return tree;
}

void set_tip(FrameTree& tree, std::string_view arm, const Isometry3d& X_BT) {
    tree.set(std::string(arm) + "_tip", std::string(arm) + "_base", X_BT);
}

}  // namespace atropos::robot
