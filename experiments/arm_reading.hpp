#pragma once

#include <array>
#include <vector>

#include "robot/robot_arm.hpp"
#include "scenes/capsule.hpp"

namespace atropos::experiments {

constexpr int kArms = 3;  ///< PSM1, PSM2, PSM3
constexpr int kScissorsArm = 2;

/// What a real system knows of an arm: its kinematics, its registration to the camera, its newest
/// measurement.
struct ArmReading {
    const robot::Psm* psm = nullptr;
    Eigen::Isometry3d X_CB = Eigen::Isometry3d::Identity();  ///< base in C, as registered
    robot::ArmState measured;

    /// Grip point in C.
    Eigen::Vector3d grip_C() const { return measured.X_CT * psm->tool().X_TG.translation(); }
    /// The instrument in C.
    std::vector<scenes::Capsule> capsules_C() const;
};

using ArmReadings = std::array<ArmReading, kArms>;

ArmReading read(const robot::RobotArm& arm);

}  // namespace atropos::experiments
