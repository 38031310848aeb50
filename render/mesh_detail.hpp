#pragma once

#include "scenes/triangle_mesh.hpp"

namespace atropos::render {

/// Area-weighted vertex normals.
std::vector<Eigen::Vector3f> smooth_normals(const scenes::TriangleMesh& mesh);

/// Directions of growing first texture coordinate, one a vertex; zero where there are no coordinates.
std::vector<Eigen::Vector3f> tangents(const scenes::TriangleMesh& mesh);

/// The same surface with no edge longer than `max_edge_m`: shared edges are halved for both neighbours, so
/// that nothing gapes. Normals and texture coordinates are carried along.
scenes::TriangleMesh refined(scenes::TriangleMesh mesh, double max_edge_m);

}  // namespace atropos::render
