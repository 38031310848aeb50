#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "scenes/stereo_rig.hpp"

namespace atropos::tracker {

/// What the right eye is off by against its calibration, so far as pictures can tell: its rows, and its turn
/// about its own axis. Columns and yaw are not told apart from depth.
struct EyeCorrection {
    double row_px = 0.0;    ///< added to the rows of the right picture
    double roll_rad = 0.0;  ///< the right camera's turn: p_R = Rz(roll) X_RC p_C

    scenes::StereoRig applied_to(scenes::StereoRig rig) const {
        rig.right.cy_px += row_px;
        rig.X_RC = Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()) * rig.X_RC;
        return rig;
    }
};

/// What it was found to be, so far.
struct EyeFound {
    EyeCorrection correction;
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of row (px) and roll (rad)

    EyeCorrection sigmas() const { return {std::sqrt(covariance(0, 0)), std::sqrt(covariance(1, 1))}; }
};

}  // namespace atropos::tracker
