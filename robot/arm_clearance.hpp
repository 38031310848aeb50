#pragma once

#include <functional>
#include <vector>

#include "scenes/capsule.hpp"

namespace atropos::robot {

using Capsules = std::vector<scenes::Capsule>;

/// Clear distance between two groups of capsules in one frame; negative when they overlap, +infinity when one
/// is empty.
double clearance_m(const Capsules& first, const Capsules& second);

/// A group of capsules on its way, at a share of the way in [0, 1]; always the same capsules in the same
/// order.
using MovingCapsules = std::function<Capsules(double)>;

struct Sweep {
    double clearance_m;  ///< never more than the true least clearance of the motion
    double at;           ///< share of the way where it was found
};

/// Least clearance of two groups that move at the same time: the swept capsules between samples are enclosed,
/// and halved until the enclosure costs at most `tolerance_m`. Groups whose clearance stays above `enough_m`
/// are not refined further.
Sweep swept_clearance(const MovingCapsules& first, const MovingCapsules& second, double tolerance_m = 0.25e-3,
                      double enough_m = 1.0);

}  // namespace atropos::robot
