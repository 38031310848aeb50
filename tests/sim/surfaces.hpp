#pragma once

#include <Eigen/Core>
#include <functional>

#include "scenes/triangle_mesh.hpp"

namespace atropos::sim::testing {

/// Square height field of `cells` x `cells` over [-half, half]^2, front faces up.
inline scenes::TriangleMesh height_field(double half_m, int cells,
                                         const std::function<double(double, double)>& z) {
    scenes::TriangleMesh mesh;
    for (int j = 0; j <= cells; ++j)
        for (int i = 0; i <= cells; ++i) {
            const double x = half_m * (2.0 * i / cells - 1.0), y = half_m * (2.0 * j / cells - 1.0);
            mesh.vertices.push_back(Eigen::Vector3d(x, y, z(x, y)).cast<float>());
        }
    const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(j * (cells + 1) + i); };
    for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i) {
            mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return mesh;
}

/// Closed box with its top at z = 0.
inline scenes::TriangleMesh box(double half_m, double depth_m) {
    scenes::TriangleMesh mesh;
    for (int k = 0; k < 8; ++k)
        mesh.vertices.push_back(
            Eigen::Vector3d(k & 1 ? half_m : -half_m, k & 2 ? half_m : -half_m, k & 4 ? 0.0 : -depth_m)
                .cast<float>());
    mesh.triangles = {{4, 5, 7}, {4, 7, 6}, {0, 2, 3}, {0, 3, 1}, {0, 1, 5}, {0, 5, 4},
                      {1, 3, 7}, {1, 7, 5}, {3, 2, 6}, {3, 6, 7}, {2, 0, 4}, {2, 4, 6}};
    return mesh;
}

/// Distance of a point above the triangle it lies over, along the triangle's normal.
inline double height_above(const scenes::TriangleMesh& mesh, const Eigen::Vector3d& p) {
    double best = 1e9;
    for (const auto& t : mesh.triangles) {
        const Eigen::Vector3d a = mesh.vertices[t[0]].cast<double>(), b = mesh.vertices[t[1]].cast<double>(),
                              c = mesh.vertices[t[2]].cast<double>();
        const auto side = [&](const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
            return (v.x() - u.x()) * (p.y() - u.y()) - (v.y() - u.y()) * (p.x() - u.x());
        };
        if (side(a, b) < 0 || side(b, c) < 0 || side(c, a) < 0) continue;
        const Eigen::Vector3d n = (b - a).cross(c - a).normalized();
        best = std::min(best, n.dot(p - a));
    }
    return best;
}

}  // namespace atropos::sim::testing
