#pragma once

#include <vector>

#include "robot/arm_team.hpp"
#include "robot/layout_defaults.hpp"

namespace atropos::robot {

/// The three arms of the default layout, holding and parked.
struct DefaultArms {
    Layout layout = default_layout();
    LayoutDefaults defaults;
    scenes::StereoRig rig = scenes::rig_preset("paper").rig;
    FrameTree tree = frame_tree(layout, rig);

    Joints start(size_t i) const {
        const ArmPlacement& arm = layout.arms[i];
        const Psm psm(tool(arm.tool));
        const auto X_WF = i < 2 ? defaults.X_WG()[i] : defaults.X_WS_parked(arm.X_WB.translation());
        return joints_for(psm, arm.X_WB, X_WF, i < 2 ? psm.tool().X_TG : *psm.tool().X_TS).q;
    }
    RobotArm make(size_t i, const Imperfection& imperfection = {}, std::uint64_t seed = 1) const {
        return RobotArm(layout.arms[i], tree, start(i), i < 2 ? defaults.holder_jaw_rad : 0.0, imperfection,
                        seed);
    }
    ArmTeam team(const Imperfection& imperfection = {}, std::uint64_t seed = 1) const {
        const scenes::Capsule e = Ecm().capsule(layout.ecm_joints);
        const Eigen::Isometry3d X_CB = tree.pose("C", "ECM_base");
        return ArmTeam(
            {make(0, imperfection, seed), make(1, imperfection, seed), make(2, imperfection, seed)},
            {X_CB * e.a, X_CB * e.b, e.radius_m});
    }
    std::array<Eigen::Isometry3d, 2> X_CG() const {
        const Eigen::Isometry3d X_CW = tree.pose("C", "W");
        return {X_CW * defaults.X_WG()[0], X_CW * defaults.X_WG()[1]};
    }
};

}  // namespace atropos::robot
