#include "robot/path_timing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace atropos::robot {

PathTiming time_path(const Psm& psm, const CartesianPath& path, const Joints& start, const PathLimits& wanted,
                     const ArmLimits& limits) {
    PathTiming timing;
    timing.along = {wanted.speed_m_s, wanted.acceleration_m_s2, wanted.jerk_m_s3};
    const int count = std::clamp(static_cast<int>(path.length_m() / 0.0005), 8, 4000);
    const double h = path.length_m() / count;
    std::vector<Joints> q(static_cast<size_t>(count) + 1);
    Joints near = start;
    for (int i = 0; i <= count; ++i) {
        const auto solution = psm.inverse(path.at(h * i), near);
        // A turn of roll cannot happen on a continuous path; it means that the roll limit is in the way.
        const bool jumps = i > 0 && std::abs(solution.q[3] - near[3]) > 1.0;
        if (!solution || jumps) {
            char where[64];
            std::snprintf(where, sizeof where, " at %.1f mm of the path", 1e3 * h * i);
            timing.refusal = (solution ? std::string("roll limit") : reason(solution)) + where;
            return timing;
        }
        near = q[static_cast<size_t>(i)] = solution.q;
    }
    timing.end = near;
    // With q(u(t)): q' v, q' a + q'' v^2, q' j + 3 q'' v a + q''' v^3 are the joint's velocity, acceleration
    // and jerk; each term gets its share of the limit.
    MotionLimits& along = timing.along;
    for (size_t i = 1; i + 2 < q.size(); ++i)
        for (int k = 0; k < 6; ++k) {
            const MotionLimits& joint = limits.joints[static_cast<size_t>(k)];
            const double d1 = std::abs(q[i + 1][k] - q[i - 1][k]) / (2.0 * h) + 1e-12;
            const double d2 = std::abs(q[i + 1][k] - 2.0 * q[i][k] + q[i - 1][k]) / (h * h) + 1e-12;
            const double d3 =
                std::abs(q[i + 2][k] - 3.0 * q[i + 1][k] + 3.0 * q[i][k] - q[i - 1][k]) / (h * h * h) + 1e-12;
            along.velocity =
                std::min({along.velocity, 0.9 * joint.velocity / d1, std::sqrt(0.3 * joint.acceleration / d2),
                          std::cbrt(0.2 * joint.jerk / d3)});
            along.acceleration = std::min(along.acceleration, 0.4 * joint.acceleration / d1);
            along.jerk = std::min(along.jerk, 0.3 * joint.jerk / d1);
            along.acceleration = std::min(along.acceleration, 0.1 * joint.jerk / (d2 * along.velocity));
        }
    return timing;
}

}  // namespace atropos::robot
