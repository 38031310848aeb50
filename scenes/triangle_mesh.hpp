#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace atropos::scenes {

/// Triangles with counter-clockwise front faces; metres, in the mesh's own frame.
/// `normals` and `texture_coordinates` are empty or have one entry a vertex.
struct TriangleMesh {
    std::vector<Eigen::Vector3f> vertices;
    std::vector<Eigen::Vector3f> normals;
    std::vector<Eigen::Vector2f> texture_coordinates;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

}  // namespace atropos::scenes
