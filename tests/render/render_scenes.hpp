#pragma once

#include <memory>
#include <vector>

#include "render/stereo_endoscope.hpp"

namespace atropos::render {

/// A square of side 2 * half_m in the mesh's x-y plane, facing -z (towards a camera that looks along +z).
inline std::shared_ptr<const scenes::TriangleMesh> square(float half_m, int cells = 1) {
    auto mesh = std::make_shared<scenes::TriangleMesh>();
    for (int j = 0; j <= cells; ++j) {
        for (int i = 0; i <= cells; ++i) {
            const auto at = [&](int k) {
                return half_m * (2.0f * static_cast<float>(k) / static_cast<float>(cells) - 1.0f);
            };
            mesh->vertices.emplace_back(at(i), at(j), 0.0f);
        }
    }
    const auto row = static_cast<std::uint32_t>(cells + 1);
    for (std::uint32_t j = 0; j + 1 < row; ++j) {
        for (std::uint32_t i = 0; i + 1 < row; ++i) {
            const std::uint32_t a = j * row + i;
            mesh->triangles.push_back({a, a + row + 1, a + 1});
            mesh->triangles.push_back({a, a + row, a + row + 1});
        }
    }
    return mesh;
}

/// A sphere about the mesh's origin, outside in front.
inline std::shared_ptr<const scenes::TriangleMesh> sphere(double radius_m, int rings) {
    auto mesh = std::make_shared<scenes::TriangleMesh>();
    const int around = 2 * rings;
    for (int j = 0; j <= rings; ++j) {
        for (int i = 0; i <= around; ++i) {
            const double theta = M_PI * j / rings, phi = M_PI * 2.0 * i / around;
            mesh->vertices.push_back(
                (radius_m * Eigen::Vector3d(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                                            std::cos(theta)))
                    .cast<float>());
        }
    }
    const auto row = static_cast<std::uint32_t>(around + 1);
    for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(rings); ++j) {
        for (std::uint32_t i = 0; i + 1 < row; ++i) {
            const std::uint32_t a = j * row + i;
            mesh->triangles.push_back({a, a + row, a + row + 1});
            mesh->triangles.push_back({a, a + row + 1, a + 1});
        }
    }
    return mesh;
}

/// A camera-aligned scene: W is C.
inline scenes::RenderItem item_at(std::shared_ptr<const scenes::TriangleMesh> mesh,
                                  const Eigen::Vector3d& p_C, scenes::Label label) {
    scenes::RenderItem item;
    item.mesh = std::move(mesh);
    item.X_WM.translation() = p_C;
    item.label = label;
    return item;
}

inline bool same_bytes(const cv::Mat& a, const cv::Mat& b) {
    return a.type() == b.type() && a.size() == b.size() &&
           std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

inline bool same_bytes(const EyeFrame& a, const EyeFrame& b) {
    return same_bytes(a.linear, b.linear) && same_bytes(a.depth_m, b.depth_m) &&
           same_bytes(a.labels, b.labels) && same_bytes(a.coverage, b.coverage);
}

inline bool same_bytes(const StereoFrame& a, const StereoFrame& b) {
    return same_bytes(a.left, b.left) && same_bytes(a.right, b.right);
}

}  // namespace atropos::render
