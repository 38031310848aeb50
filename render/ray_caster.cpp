#include "render/ray_caster.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

namespace atropos::render {
namespace {

constexpr std::size_t kLeafSize = 4;

}  // namespace

RayCaster::RayCaster(const scenes::TriangleMesh& mesh) {
    std::vector<Triangle> triangles;
    triangles.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) {
        triangles.push_back(
            {mesh.vertices[a], mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]});
    }
    if (!triangles.empty()) build(triangles, 0, triangles.size());
    triangles_ = std::move(triangles);
}

void RayCaster::build(std::vector<Triangle>& triangles, std::size_t first, std::size_t end) {
    Eigen::Array3f low = Eigen::Array3f::Constant(std::numeric_limits<float>::infinity()), high = -low;
    for (std::size_t i = first; i < end; ++i) {
        const Triangle& t = triangles[i];
        const Eigen::Array3f a = t.a, b = t.a + t.ab, c = t.a + t.ac;
        low = low.min(a).min(b).min(c);
        high = high.max(a).max(b).max(c);
    }
    const Eigen::Array3f margin = 1e-6f * (1.0f + high.abs().max(low.abs()));  // corners are rounded sums
    const std::size_t node = nodes_.size();
    nodes_.push_back({low - margin, high + margin, static_cast<std::uint32_t>(first),
                      static_cast<std::uint32_t>(end - first)});
    if (end - first <= kLeafSize) return;
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const std::size_t middle = (first + end) / 2;
    const auto centre = [axis](const Triangle& t) { return 3.0f * t.a[axis] + t.ab[axis] + t.ac[axis]; };
    const auto at = [&](std::size_t i) { return triangles.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(first), at(middle), at(end),
                     [&](const Triangle& x, const Triangle& y) { return centre(x) < centre(y); });
    build(triangles, first, middle);
    nodes_[node].first = static_cast<std::uint32_t>(nodes_.size());
    nodes_[node].count = 0;
    build(triangles, middle, end);
}

std::optional<double> RayCaster::cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                      double t_max) const {
    if (nodes_.empty()) return std::nullopt;
    const Eigen::Array3d inverse = direction.array().inverse();
    std::array<std::uint32_t, 64> stack;
    std::size_t depth = 0;
    stack[depth++] = 0;
    double nearest = t_max;
    while (depth > 0) {
        const std::uint32_t index = stack[--depth];
        const Node& node = nodes_[index];
        const Eigen::Array3d t0 = (node.low.cast<double>() - origin.array()) * inverse;
        const Eigen::Array3d t1 = (node.high.cast<double>() - origin.array()) * inverse;
        const double enter = std::max(t0.min(t1).maxCoeff(), 0.0),
                     leave = std::min(t0.max(t1).minCoeff(), nearest);
        if (!(enter <= leave)) continue;
        if (node.count == 0) {
            stack[depth++] = index + 1;
            stack[depth++] = node.first;
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            // Moeller and Trumbore 1997, front faces only.
            const Eigen::Vector3d ab = triangles_[i].ab.cast<double>(), ac = triangles_[i].ac.cast<double>();
            const Eigen::Vector3d p = direction.cross(ac), from_a = origin - triangles_[i].a.cast<double>();
            const double determinant = ab.dot(p);
            if (determinant <= 0.0) continue;
            const double u = from_a.dot(p);
            const Eigen::Vector3d q = from_a.cross(ab);
            const double v = direction.dot(q);
            if (u < 0.0 || v < 0.0 || u + v > determinant) continue;
            const double t = ac.dot(q) / determinant;
            if (t > 0.0 && t < nearest) nearest = t;
        }
    }
    if (nearest < t_max) return nearest;
    return std::nullopt;
}

}  // namespace atropos::render
