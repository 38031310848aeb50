#include "render/mesh_detail.hpp"

#include <Eigen/Geometry>
#include <map>
#include <utility>

namespace atropos::render {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

// Splits every edge longer than the limit once; false when there was none.
class EdgeSplitter {
  public:
    EdgeSplitter(scenes::TriangleMesh& mesh, float max_edge_m)
        : mesh_(mesh), limit2_(max_edge_m * max_edge_m) {}

    bool split_all() {
        std::vector<Triangle> result;
        result.reserve(mesh_.triangles.size());
        for (const Triangle& triangle : mesh_.triangles) split(triangle, result);
        mesh_.triangles = std::move(result);
        return !middles_.empty();
    }

  private:
    bool is_long(std::uint32_t a, std::uint32_t b) const {
        return (mesh_.vertices[a] - mesh_.vertices[b]).squaredNorm() > limit2_;
    }

    std::uint32_t middle(std::uint32_t a, std::uint32_t b) {
        const auto [entry, is_new] =
            middles_.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh_.vertices.size()));
        if (is_new) {
            mesh_.vertices.push_back(0.5f * (mesh_.vertices[a] + mesh_.vertices[b]));
            if (!mesh_.normals.empty()) {
                mesh_.normals.push_back((mesh_.normals[a] + mesh_.normals[b]).normalized());
            }
            if (!mesh_.texture_coordinates.empty()) {
                mesh_.texture_coordinates.push_back(
                    0.5f * (mesh_.texture_coordinates[a] + mesh_.texture_coordinates[b]));
            }
        }
        return entry->second;
    }

    void split(Triangle t, std::vector<Triangle>& out) {
        int count = 0;
        for (int i = 0; i < 3; ++i) count += is_long(t[i], t[(i + 1) % 3]);
        if (count == 0) {
            out.push_back(t);
            return;
        }
        // Turn the triangle so that its first edge is long, and with two long edges its third is the short
        // one.
        while (!is_long(t[0], t[1]) || (count == 2 && is_long(t[2], t[0]))) t = {t[1], t[2], t[0]};
        const std::uint32_t m01 = middle(t[0], t[1]);
        if (count == 1) {
            out.insert(out.end(), {{t[0], m01, t[2]}, {m01, t[1], t[2]}});
            return;
        }
        const std::uint32_t m12 = middle(t[1], t[2]);
        out.push_back({m01, t[1], m12});
        if (count == 2) {
            out.insert(out.end(), {{t[0], m01, m12}, {t[0], m12, t[2]}});
            return;
        }
        const std::uint32_t m20 = middle(t[2], t[0]);
        out.insert(out.end(), {{t[0], m01, m20}, {m01, m12, m20}, {m20, m12, t[2]}});
    }

    scenes::TriangleMesh& mesh_;
    float limit2_;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles_;
};

}  // namespace

std::vector<Eigen::Vector3f> smooth_normals(const scenes::TriangleMesh& mesh) {
    std::vector<Eigen::Vector3f> normals(mesh.vertices.size(), Eigen::Vector3f::Zero());
    for (const auto& [a, b, c] : mesh.triangles) {
        const Eigen::Vector3f n =
            (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
        for (const std::uint32_t i : {a, b, c}) normals[i] += n;
    }
    for (Eigen::Vector3f& n : normals) n = n.squaredNorm() > 0.0f ? n.normalized() : Eigen::Vector3f::UnitZ();
    return normals;
}

std::vector<Eigen::Vector3f> tangents(const scenes::TriangleMesh& mesh) {
    std::vector<Eigen::Vector3f> result(mesh.vertices.size(), Eigen::Vector3f::Zero());
    if (mesh.texture_coordinates.empty()) return result;
    for (const auto& [a, b, c] : mesh.triangles) {
        const Eigen::Vector2f ab = mesh.texture_coordinates[b] - mesh.texture_coordinates[a];
        const Eigen::Vector2f ac = mesh.texture_coordinates[c] - mesh.texture_coordinates[a];
        const Eigen::Vector3f t =
            (mesh.vertices[b] - mesh.vertices[a]) * ac.y() - (mesh.vertices[c] - mesh.vertices[a]) * ab.y();
        const float area = ab.x() * ac.y() - ab.y() * ac.x();
        for (const std::uint32_t i : {a, b, c}) result[i] += area < 0.0f ? Eigen::Vector3f(-t) : t;
    }
    for (Eigen::Vector3f& t : result) t = t.squaredNorm() > 0.0f ? t.normalized() : Eigen::Vector3f::UnitX();
    return result;
}

scenes::TriangleMesh refined(scenes::TriangleMesh mesh, double max_edge_m) {
    constexpr int kMaxRounds = 10;  // halves 1 m down to 1 mm
    for (int round = 0; round < kMaxRounds; ++round) {
        if (!EdgeSplitter(mesh, static_cast<float>(max_edge_m)).split_all()) break;
    }
    return mesh;
}

}  // namespace atropos::render
