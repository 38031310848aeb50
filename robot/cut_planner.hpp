#pragma once

#include <Eigen/Geometry>
#include <span>
#include <string>
#include <vector>

#include "robot/psm.hpp"
#include "robot/scissors_options.hpp"
#include "scenes/thread_estimate.hpp"

namespace atropos::robot {

/// What an approach is chosen from; all in C as measured.
struct CutScene {
    Eigen::Vector3d target_C = Eigen::Vector3d::Zero();
    Eigen::Vector3d tangent_C = Eigen::Vector3d::UnitX();
    Eigen::Isometry3d X_CS = Eigen::Isometry3d::Identity();  ///< blades now
    Eigen::Isometry3d X_CB = Eigen::Isometry3d::Identity();
    Joints q = Joints::Zero();
    double open_jaw_rad = 0.0;
    std::span<const scenes::Capsule> others_C;
    std::span<const scenes::ThreadSample> thread;
};

/// How the blades come to the thread.
struct CutPlan {
    bool found = false;
    std::string refusal;  ///< when nothing was found: what stands in the way
    Eigen::Vector3d approach_C = Eigen::Vector3d::UnitZ();  ///< z_S as near as it can be across the thread
    double tangent_sign = 1.0;                              ///< y_S = sign * tangent
    double clearance_m = 0.0;                               ///< least on the way, to all others
    double depth_cover = 0.0;                               ///< |cos| between opening and viewing direction
};

/// Orientation of the blades: y along the thread, z as near as can be to `approach`.
Eigen::Matrix3d blade_rotation(const Eigen::Vector3d& along_thread, const Eigen::Vector3d& approach);

/// Turns the blade plane about the thread and looks at every direction from which the arm can come: joints
/// away from their limits, shafts clear of each other on the straight way to the stand-off point and from
/// there to the thread, neither eye's view of the target behind wrist or shaft, the thread not touched on the
/// way. Of those the best opens its blades along the viewing ray, where the cameras know least, with little
/// bending of the wrist.
CutPlan plan_cut(const Psm& psm, const CutScene& scene, const ScissorsOptions& options);

}  // namespace atropos::robot
