#include "tracker/instrument_shadow.hpp"

#include <algorithm>
#include <cmath>

namespace atropos::tracker {
namespace {

/// Calls `visit(u, v)` for the pixels of the map in a circle until it returns true; whether it did.
template <class Visit>
bool any_in_circle(const RidgePointMap& map, const Eigen::Vector2d& centre, double radius, Visit&& visit) {
    const auto within = [](double value, int size) {
        return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(size)));
    };
    for (int v = within(centre.y() - radius, map.height); v < within(centre.y() + radius + 1.0, map.height);
         ++v)
        for (int u = within(centre.x() - radius, map.width); u < within(centre.x() + radius + 1.0, map.width);
             ++u)
            if ((Eigen::Vector2d(u, v) - centre).squaredNorm() < radius * radius && visit(u, v)) return true;
    return false;
}

}  // namespace

void hide_instruments(std::span<const scenes::Capsule> instruments_C, const scenes::Camera& camera,
                      const Eigen::Isometry3d& X_EC, double margin_px, RidgePointMap& map) {
    if (instruments_C.empty()) return;
    const auto hide = [&](int u, int v) {
        map.at_pixel[static_cast<std::size_t>(v) * static_cast<std::size_t>(map.width) +
                     static_cast<std::size_t>(u)] = RidgePointMap::kHidden;
        return false;
    };
    for (const scenes::Capsule& capsule : instruments_C) {
        const Eigen::Vector3d a = X_EC * capsule.a, b = X_EC * capsule.b;
        constexpr int kSpheres = 100;
        for (int i = 0; i <= kSpheres; ++i) {
            const Eigen::Vector3d p = a + static_cast<double>(i) / kSpheres * (b - a);
            if (p.z() < 0.01) continue;
            const Eigen::Vector2d centre = camera.project(p);
            const double radius = capsule.radius_m * camera.fx_px / p.z() + margin_px;
            if (centre.allFinite() && radius < 1e4) any_in_circle(map, centre, radius, hide);
        }
    }
    std::vector<RidgePoint> kept;
    for (std::int32_t& index : map.at_pixel) {
        if (index < 0) continue;
        kept.push_back(map.points[static_cast<std::size_t>(index)]);
        index = static_cast<std::int32_t>(kept.size()) - 1;
    }
    map.points = std::move(kept);
}

bool near_hidden(const RidgePointMap& map, const Eigen::Vector2d& px, double reach_px) {
    return any_in_circle(map, px, reach_px,
                         [&](int u, int v) { return map.index(u, v) == RidgePointMap::kHidden; });
}

void reach_instruments(ImagePath& path, const RidgePointMap& map, double margin_px) {
    for (int side = 0; side < 2; ++side) {
        path.reverse();  // both ends in turn, and as it was in the end
        if (!near_hidden(map, path.points.back().px, 3.0)) continue;
        const PathEnd end = path_end(path, false);
        for (int i = 1; i <= static_cast<int>(margin_px); ++i)
            path.points.push_back({end.p + i * end.out, end.out, 0.0});
    }
}

}  // namespace atropos::tracker
