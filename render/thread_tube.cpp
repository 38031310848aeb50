#include "render/thread_tube.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace atropos::render {

scenes::TriangleMesh thread_tube(const ThreadRibbon& ribbon, int sides) {
    scenes::TriangleMesh mesh;
    const auto& points = ribbon.curve_W.points;
    if (points.size() < 2) return mesh;
    Eigen::Vector3d across = (points[1] - points[0]).unitOrthogonal();
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector3d along =
            (points[std::min(i + 1, points.size() - 1)] - points[i > 0 ? i - 1 : 0]).normalized();
        across = (across - along * along.dot(across)).normalized();  // carried along without twist
        const Eigen::Vector3d other = along.cross(across);
        for (int k = 0; k < sides; ++k) {
            const double angle = 2.0 * std::numbers::pi * k / sides;
            const Eigen::Vector3d n = std::cos(angle) * across + std::sin(angle) * other;
            mesh.vertices.push_back((points[i] + ribbon.radius_m * n).cast<float>());
            mesh.normals.push_back(n.cast<float>());
        }
    }
    const auto n = static_cast<std::uint32_t>(sides);
    for (std::uint32_t i = 0; i + 1 < points.size(); ++i) {
        for (std::uint32_t k = 0; k < n; ++k) {
            const std::uint32_t a = i * n + k, b = i * n + (k + 1) % n;
            mesh.triangles.push_back({a, b, b + n});
            mesh.triangles.push_back({a, b + n, a + n});
        }
    }
    return mesh;
}

}  // namespace atropos::render
