#pragma once

#include <Eigen/Geometry>

#include "robot/joint.hpp"

namespace atropos::robot {

/// What the physics, the renderer and the judge may see. There is no way from it to Measured.
template <class T>
struct True {
    T value;
};

/// What a real system would know: with the arm's errors, at the time of the measurement.
template <class T>
struct Measured {
    T value;
};

struct ArmState {
    double time_s = 0.0;
    Joints q = Joints::Zero();
    double jaw_rad = 0.0;
    Eigen::Isometry3d X_CT = Eigen::Isometry3d::Identity();  ///< tip in the left camera
};

}  // namespace atropos::robot
