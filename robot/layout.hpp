#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "robot/ecm.hpp"
#include "robot/frame_tree.hpp"
#include "robot/psm.hpp"
#include "scenes/stereo_rig.hpp"

namespace atropos::robot {

/// Where a PSM stands and what it carries.
struct ArmPlacement {
    std::string name;  ///< PSM1, PSM2, PSM3
    Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
    std::string tool = "LARGE_NEEDLE_DRIVER";
};

/// Bases of all arms. The camera hangs on an ECM, or stands free at `X_WE` (dVRK's camera frame: x left, y
/// up).
struct Layout {
    std::vector<ArmPlacement> arms;
    Eigen::Isometry3d X_WEcm = Eigen::Isometry3d::Identity();  ///< ECM base
    EcmJoints ecm_joints = EcmJoints::Zero();
    std::optional<Eigen::Isometry3d> X_WE;  ///< set: no ECM

    /// Throws std::invalid_argument that lists the known names.
    const ArmPlacement& arm(std::string_view name) const;
};

/// Base pose with its remote centre at `p_WB`, the shaft at zero aimed at `p_WTarget`, and base y as near as
/// can be to `along_y_W`.
Eigen::Isometry3d aimed_base(const Eigen::Vector3d& p_WB, const Eigen::Vector3d& p_WTarget,
                             const Eigen::Vector3d& along_y_W);

/// dvrk_simulator_base's ECM_PSM1_PSM2_PSM3.yaml (remote centres 0.2 m from the target at W's origin), PSM3
/// moved opposite the camera; lenses `working_distance_m` from the target.
Layout default_layout(double working_distance_m = 0.1);

/// The fixed-camera rig of dVRK's jhu-dVRK console file: two PSMs 0.2 m to each side of the camera. W has the
/// orientation of the PSM bases, its origin 0.1 m before the camera.
Layout lab_rig();

/// dVRK's camera frame of an eye: a half turn about the viewing axis from OpenCV's (either way).
Eigen::Isometry3d half_turn_about_z();

/// All frames: W, NAME_base, NAME_tip, NAME_grip, NAME_blade (scissors) for each PSM; ECM_base, ECM_tip
/// (middle between the lenses), C and R (OpenCV's left and right camera), ECM (C as dVRK turns it).
FrameTree frame_tree(const Layout& layout, const scenes::StereoRig& rig);

/// Moves NAME_tip (and with it grip and blade).
void set_tip(FrameTree& tree, std::string_view arm, const Eigen::Isometry3d& X_BT);

}  // namespace atropos::robot
