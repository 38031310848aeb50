#include "render/mesh_file.hpp"

#include <assimp/mesh.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "render/ply_check.hpp"
#include "scenes/file_error.hpp"

namespace atropos::render {
namespace {

constexpr std::uintmax_t kLargestFile_bytes = 512u << 20;
constexpr std::size_t kMostTriangles = 20'000'000;

[[noreturn]] void fail(const std::string& path, const std::string& what) {
    std::string line = what;
    std::replace_if(
        line.begin(), line.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }, ' ');
    throw scenes::FileError(path, line);
}

void check_file(const std::string& path) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) fail(path, "no such file, expected a mesh");
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (error || size == 0) fail(path, "empty file, expected a mesh");
    if (size > kLargestFile_bytes) fail(path, "larger than 512 MiB, expected a smaller mesh");
}

// By name or by content, as assimp chooses its reader.
bool is_ply(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string(), magic(3, ' ');
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    std::ifstream(path, std::ios::binary).read(magic.data(), 3);
    return extension == ".ply" || magic == "ply";
}

const aiScene& read(Assimp::Importer& importer, const std::string& path) {
    check_file(path);
    if (is_ply(path)) check_ply(path);
    importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    const aiScene* scene = nullptr;
    try {
        scene = importer.ReadFile(path, aiProcess_Triangulate | aiProcess_PreTransformVertices |
                                            aiProcess_SortByPType | aiProcess_JoinIdenticalVertices);
    } catch (const std::exception& error) {
        fail(path,
             std::string("not a readable mesh (") + error.what() + "), expected OBJ, STL, PLY, DAE or glTF");
    }
    if (!scene || scene->mNumMeshes == 0) {
        fail(path, std::string("not a readable mesh (") + importer.GetErrorString() +
                       "), expected OBJ, STL, PLY, DAE or glTF");
    }
    return *scene;
}

// Appends; vertices of the part get normals only when all had them.
void append(const std::string& path, const aiMesh& source, double scale_to_m, scenes::TriangleMesh& mesh) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    const auto scale = static_cast<float>(scale_to_m);
    for (unsigned i = 0; i < source.mNumVertices; ++i) {
        const aiVector3D& v = source.mVertices[i];
        const Eigen::Vector3f p = scale * Eigen::Vector3f(v.x, v.y, v.z);
        if (!p.allFinite()) fail(path, "a vertex isn't finite, expected numbers");
        mesh.vertices.push_back(p);
        if (source.HasNormals()) {
            const Eigen::Vector3f n(source.mNormals[i].x, source.mNormals[i].y, source.mNormals[i].z);
            const float length = n.norm();
            mesh.normals.push_back(length > 1e-6f && n.allFinite() ? Eigen::Vector3f(n / length)
                                                                   : Eigen::Vector3f::UnitZ());
        }
        if (source.HasTextureCoords(0)) {
            const aiVector3D& uv = source.mTextureCoords[0][i];
            mesh.texture_coordinates.emplace_back(uv.x, uv.y);
        }
    }
    for (unsigned i = 0; i < source.mNumFaces; ++i) {
        const aiFace& face = source.mFaces[i];
        if (face.mNumIndices != 3) continue;
        const std::array<std::uint32_t, 3> t = {face.mIndices[0], face.mIndices[1], face.mIndices[2]};
        if (std::any_of(t.begin(), t.end(), [&](std::uint32_t k) { return k >= source.mNumVertices; })) {
            fail(path,
                 "a triangle names a vertex that isn't there, expected indices below the number of vertices");
        }
        mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
    if (mesh.triangles.size() > kMostTriangles)
        fail(path, "more than 20 million triangles, expected a smaller mesh");
}

// Per-vertex data that only some parts of a file have would be out of step.
void drop_incomplete(scenes::TriangleMesh& mesh) {
    if (mesh.normals.size() != mesh.vertices.size()) mesh.normals.clear();
    if (mesh.texture_coordinates.size() != mesh.vertices.size()) mesh.texture_coordinates.clear();
}

scenes::Material material_of(const aiMaterial& source) {
    scenes::Material material;
    aiColor3D colour(0.5f, 0.5f, 0.5f);
    source.Get(AI_MATKEY_COLOR_DIFFUSE, colour);
    material.base_colour = {std::clamp(colour.r, 0.0f, 1.0f), std::clamp(colour.g, 0.0f, 1.0f),
                            std::clamp(colour.b, 0.0f, 1.0f)};
    source.Get(AI_MATKEY_METALLIC_FACTOR, material.metallic);
    source.Get(AI_MATKEY_ROUGHNESS_FACTOR, material.roughness);
    return material;
}

void check_scale(double scale_to_m) {
    if (!(scale_to_m > 0.0))
        throw std::invalid_argument("scale_to_m is " + std::to_string(scale_to_m) + ", expected > 0");
}

}  // namespace

scenes::TriangleMesh load_mesh(const std::string& path, double scale_to_m) {
    check_scale(scale_to_m);
    Assimp::Importer importer;
    const aiScene& scene = read(importer, path);
    scenes::TriangleMesh mesh;
    for (unsigned i = 0; i < scene.mNumMeshes; ++i) append(path, *scene.mMeshes[i], scale_to_m, mesh);
    drop_incomplete(mesh);
    if (mesh.triangles.empty()) fail(path, "no triangles, expected a surface");
    return mesh;
}

std::vector<MeshPart> load_mesh_parts(const std::string& path, double scale_to_m) {
    check_scale(scale_to_m);
    Assimp::Importer importer;
    const aiScene& scene = read(importer, path);
    std::vector<MeshPart> parts;
    for (unsigned m = 0; m < scene.mNumMaterials; ++m) {
        scenes::TriangleMesh mesh;
        for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
            if (scene.mMeshes[i]->mMaterialIndex == m) append(path, *scene.mMeshes[i], scale_to_m, mesh);
        }
        drop_incomplete(mesh);
        if (mesh.triangles.empty()) continue;
        aiString name;
        scene.mMaterials[m]->Get(AI_MATKEY_NAME, name);
        parts.push_back({name.C_Str(), material_of(*scene.mMaterials[m]),
                         std::make_shared<const scenes::TriangleMesh>(std::move(mesh))});
    }
    if (parts.empty()) fail(path, "no triangles, expected a surface");
    return parts;
}

MeshInfo mesh_info(const scenes::TriangleMesh& mesh) {
    MeshInfo info{mesh.vertices.size(), mesh.triangles.size(), {}, {}, {}};
    if (mesh.vertices.empty()) return info;
    info.low_m = info.high_m = mesh.vertices[0].cast<double>();
    for (const Eigen::Vector3f& v : mesh.vertices) {
        info.low_m = info.low_m.cwiseMin(v.cast<double>());
        info.high_m = info.high_m.cwiseMax(v.cast<double>());
    }
    const double longest_m = (info.high_m - info.low_m).maxCoeff();
    if (longest_m < 1e-3) info.warning = "less than 1 mm across: is scale_to_m too small?";
    if (longest_m > 1.0)
        info.warning = "more than 1 m across: is scale_to_m too large (0.001 for millimetres)?";
    return info;
}

}  // namespace atropos::render
