#pragma once

#include <memory>

#include "render/gl.hpp"
#include "scenes/triangle_mesh.hpp"

namespace atropos::render {

/// A mesh in the context's memory. Needs its context current, also to die.
class GpuMesh {
  public:
    /// `max_edge_m` > 0 splits longer edges, for images with distortion.
    GpuMesh(const GlFunctions& gl, const scenes::TriangleMesh& mesh, double max_edge_m);
    ~GpuMesh();
    GpuMesh(const GpuMesh&) = delete;
    GpuMesh& operator=(const GpuMesh&) = delete;

    void draw() const;

  private:
    const GlFunctions& gl_;
    GLuint array_ = 0, vertices_ = 0, indices_ = 0;
    GLsizei count_;
};

}  // namespace atropos::render
