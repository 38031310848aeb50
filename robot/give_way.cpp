#include "robot/give_way.hpp"

#include <algorithm>

#include "robot/psm_arm.hpp"

namespace atropos::robot {

using Eigen::Vector3d;

Neighbourhood neighbourhood(std::span<const scenes::Capsule> own, std::span<const scenes::Capsule> others,
                            double wanted_clearance_m) {
    Neighbourhood result;
    Vector3d up = Vector3d::Zero(), down = Vector3d::Zero();
    for (const scenes::Capsule& a : own)
        for (const scenes::Capsule& b : others) {
            const auto [s, t, distance_m] = scenes::segment_distance(a.a, a.b, b.a, b.b);
            const double clearance_m = distance_m - a.radius_m - b.radius_m;
            result.clearance_m = std::min(result.clearance_m, clearance_m);
            if (clearance_m >= wanted_clearance_m) continue;
            const Vector3d away = (a.a + s * (a.b - a.a) - b.a - t * (b.b - b.a)).normalized();
            const Vector3d out = (wanted_clearance_m - clearance_m) * away;
            up = up.cwiseMax(out);
            down = down.cwiseMin(out);
        }
    result.way_out_m = up + down;
    return result;
}

void GiveWay::step(const Neighbourhood& neighbourhood) {
    const auto limited = [&](const Vector3d& v) {
        return Vector3d(v * std::min(1.0, options_.speed_m_s / std::max(v.norm(), 1e-12)));
    };
    const Vector3d wanted =
        limited(neighbourhood.way_out_m / options_.push_s) - limited(offset_ / options_.back_s);
    rate_ += PsmArm::kPeriod_s / options_.smooth_s * (wanted - rate_);
    offset_ += PsmArm::kPeriod_s * rate_;
}

}  // namespace atropos::robot
