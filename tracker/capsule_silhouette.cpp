#include "tracker/capsule_silhouette.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace atropos::tracker {
namespace {

/// Where the ray from the eye (origin) grazes a sphere, on the side of `across` (unit, perpendicular to c).
Eigen::Vector3d grazing_point(const Eigen::Vector3d& c, double radius_m, const Eigen::Vector3d& across) {
    const double distance = c.norm();
    const double sine = std::min(radius_m / distance, 0.99);
    return c + radius_m * (std::sqrt(1.0 - sine * sine) * across - sine * c / distance);
}

bool inside_another(const Eigen::Vector3d& p, std::span<const scenes::Capsule> capsules, std::size_t own) {
    const Eigen::Vector3d far = 3.0 * p;
    for (std::size_t i = 0; i < capsules.size(); ++i)
        if (i != own &&
            scenes::segment_distance(Eigen::Vector3d::Zero(), far, capsules[i].a, capsules[i].b).distance_m <
                capsules[i].radius_m)
            return true;
    return false;
}

}  // namespace

std::vector<SilhouettePoint> capsule_silhouette(std::span<const scenes::Capsule> capsules,
                                                const scenes::Camera& camera, double step_px) {
    std::vector<SilhouettePoint> outline;
    const auto add = [&](const Eigen::Vector3d& c, double radius_m, const Eigen::Vector3d& across,
                         std::size_t own) {
        if (c.z() < 0.01) return;
        SilhouettePoint point;
        point.p = grazing_point(c, radius_m, across);
        point.px = camera.project(point.p, point.px_per_m);
        if (!camera.contains(point.px) || inside_another(point.p, capsules, own)) return;
        const Eigen::Vector2d outward = point.px_per_m * across;
        if (outward.norm() < 1e-9) return;
        point.normal = outward.normalized();
        outline.push_back(point);
    };
    for (std::size_t i = 0; i < capsules.size(); ++i) {
        const scenes::Capsule& capsule = capsules[i];
        const double m_per_step =
            step_px * std::max(std::min(capsule.a.z(), capsule.b.z()), 0.02) / camera.fx_px;
        const Eigen::Vector3d axis = capsule.b - capsule.a;
        const int along = std::clamp(static_cast<int>(axis.norm() / m_per_step), 1, 400);
        for (int j = 0; j <= along; ++j) {
            const Eigen::Vector3d c = capsule.a + (static_cast<double>(j) / along) * axis;
            const Eigen::Vector3d side = c.cross(axis);
            if (side.norm() < 1e-12) break;  // seen along its axis: the end is the whole outline
            add(c, capsule.radius_m, side.normalized(), i);
            add(c, capsule.radius_m, -side.normalized(), i);
        }
        const int around =
            std::clamp(static_cast<int>(std::numbers::pi * capsule.radius_m / m_per_step), 4, 100);
        for (const auto& [c, outward] :
             {std::pair(capsule.a, Eigen::Vector3d(-axis)), std::pair(capsule.b, axis)})
            for (int j = 0; j < 2 * around; ++j) {
                const double angle = std::numbers::pi * j / around;
                const Eigen::Vector3d first = c.unitOrthogonal();
                const Eigen::Vector3d across =
                    std::cos(angle) * first + std::sin(angle) * c.normalized().cross(first);
                if (across.dot(outward) > 1e-9 * outward.norm()) add(c, capsule.radius_m, across, i);
            }
    }
    return outline;
}

}  // namespace atropos::tracker
