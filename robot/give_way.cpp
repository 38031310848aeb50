#include "robot/give_way.hpp"

#include <algorithm>

#include "robot/psm_arm.hpp"

namespace atropos::robot {

using Eigen::Vector3d;

Nearest nearest(std::span<const scenes::Capsule> own, std::span<const scenes::Capsule> others) {
    Nearest result;
    for (const scenes::Capsule& a : own)
        for (const scenes::Capsule& b : others) {
            const auto [s, t, distance_m] = scenes::segment_distance(a.a, a.b, b.a, b.b);
            const double clearance_m = distance_m - a.radius_m - b.radius_m;
            if (clearance_m >= result.clearance_m) continue;
            result.clearance_m = clearance_m;
            result.away = (a.a + s * (a.b - a.a) - b.a - t * (b.b - b.a)).normalized();
        }
    return result;
}

void GiveWay::step(const Nearest& nearest) {
    const double room_m = std::max(0.0, options_.from_m - nearest.clearance_m);
    const Vector3d push = std::min(options_.speed_m_s, room_m / options_.push_s) * nearest.away;
    Vector3d back = -offset_ / options_.back_s;
    if (back.norm() > options_.speed_m_s) back *= options_.speed_m_s / back.norm();
    rate_ += PsmArm::kPeriod_s / options_.smooth_s * (push + back - rate_);
    offset_ += PsmArm::kPeriod_s * rate_;
}

}  // namespace atropos::robot
