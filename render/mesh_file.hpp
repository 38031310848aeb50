#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenes/render_item.hpp"

namespace atropos::render {

/// One material's share of a mesh file.
struct MeshPart {
    std::string material_name;
    scenes::Material
        material;  ///< what the file says of it; files of formats without materials give the default
    std::shared_ptr<const scenes::TriangleMesh> mesh;
};

/// Reads OBJ, STL, PLY, and DAE or glTF where assimp can, and scales to metres (0.001 for a file in mm; DAE
/// and glTF carry their unit: 1). Throws std::runtime_error with one line, `FILE: what is wrong, what was
/// expected`, for files that are missing, broken, empty, or not made of finite triangles.
scenes::TriangleMesh load_mesh(const std::string& path, double scale_to_m);

/// As `load_mesh`, kept apart by material.
std::vector<MeshPart> load_mesh_parts(const std::string& path, double scale_to_m);

/// For `atropos info MESH`.
struct MeshInfo {
    std::size_t vertices = 0;
    std::size_t triangles = 0;
    Eigen::Vector3d low_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d high_m = Eigen::Vector3d::Zero();
    std::string warning;  ///< empty, or why the size is implausible for something an endoscope sees
};
MeshInfo mesh_info(const scenes::TriangleMesh& mesh);

}  // namespace atropos::render
