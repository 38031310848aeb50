#pragma once

#include <string>

#include "robot/psm_arm.hpp"

namespace atropos::robot {

/// How fast an arm can follow a path.
struct PathTiming {
    MotionLimits along;           ///< of the path's parameter (m), so that no joint passes its limits
    Joints end = Joints::Zero();  ///< joints at the end of the path
    std::string refusal;          ///< not empty: where and why the path cannot be followed
};

/// Checks the path's reach every 0.5 mm and lowers `wanted` where a joint would need more than its limits.
PathTiming time_path(const Psm& psm, const CartesianPath& path, const Joints& start, const PathLimits& wanted,
                     const ArmLimits& limits);

}  // namespace atropos::robot
