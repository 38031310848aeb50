#pragma once

#include <algorithm>

#include "robot/psm.hpp"
#include "scenes/random_stream.hpp"

namespace atropos::robot {

/// Uniform inside the limits, with the wrist at least `Psm::kSafeDepth_m` beyond the remote centre.
inline Joints random_joints(const Psm& psm, scenes::RandomStream& random) {
    Joints q;
    for (int i = 0; i < 6; ++i) q[i] = random.uniform(psm.limits().lower[i], psm.limits().upper[i]);
    const double shallowest = Psm::kSafeDepth_m + 0.4318 - psm.tool().shaft_m;
    q[2] = random.uniform(shallowest, psm.limits().upper[2]);
    return q;
}

}  // namespace atropos::robot
