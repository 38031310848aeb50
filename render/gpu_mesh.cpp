#include "render/gpu_mesh.hpp"

#include "render/mesh_detail.hpp"

namespace atropos::render {
namespace {

struct Vertex {
    Eigen::Vector3f position;
    Eigen::Vector3f normal;
    Eigen::Vector2f uv;
    Eigen::Vector3f tangent;
};

std::vector<Vertex> interleaved(const scenes::TriangleMesh& mesh) {
    const std::vector<Eigen::Vector3f> normals = mesh.normals.empty() ? smooth_normals(mesh) : mesh.normals;
    const std::vector<Eigen::Vector3f> along_u = tangents(mesh);
    std::vector<Vertex> vertices(mesh.vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const Eigen::Vector2f uv =
            mesh.texture_coordinates.empty() ? Eigen::Vector2f::Zero().eval() : mesh.texture_coordinates[i];
        vertices[i] = {mesh.vertices[i], normals[i], uv, along_u[i]};
    }
    return vertices;
}

}  // namespace

GpuMesh::GpuMesh(const GlFunctions& gl, const scenes::TriangleMesh& source, double max_edge_m) : gl_(gl) {
    const scenes::TriangleMesh mesh = max_edge_m > 0.0 ? refined(source, max_edge_m) : source;
    const std::vector<Vertex> vertices = interleaved(mesh);
    count_ = static_cast<GLsizei>(3 * mesh.triangles.size());
    gl_.GenVertexArrays(1, &array_);
    gl_.BindVertexArray(array_);
    gl_.GenBuffers(1, &vertices_);
    gl_.BindBuffer(GL_ARRAY_BUFFER, vertices_);
    gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)),
                   vertices.data(), GL_STATIC_DRAW);
    gl_.GenBuffers(1, &indices_);
    gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
    gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER,
                   static_cast<GLsizeiptr>(mesh.triangles.size() * sizeof(mesh.triangles[0])),
                   mesh.triangles.data(), GL_STATIC_DRAW);
    const auto attribute = [&](GLuint index, GLint size, std::size_t offset) {
        gl_.EnableVertexAttribArray(index);
        gl_.VertexAttribPointer(index, size, GL_FLOAT, GL_FALSE, sizeof(Vertex),
                                reinterpret_cast<const void*>(offset));
    };
    attribute(0, 3, offsetof(Vertex, position));
    attribute(1, 3, offsetof(Vertex, normal));
    attribute(2, 2, offsetof(Vertex, uv));
    attribute(3, 3, offsetof(Vertex, tangent));
    gl_.BindVertexArray(0);
}

GpuMesh::~GpuMesh() {
    gl_.DeleteVertexArrays(1, &array_);
    gl_.DeleteBuffers(1, &vertices_);
    gl_.DeleteBuffers(1, &indices_);
}

void GpuMesh::draw() const {
    gl_.BindVertexArray(array_);
    gl_.DrawElements(GL_TRIANGLES, count_, GL_UNSIGNED_INT, nullptr);
}

}  // namespace atropos::render
