#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <memory>

#include "render/shader_program.hpp"

namespace atropos::render {

/// Depth as the lamp sees it.
class ShadowMap {
  public:
    explicit ShadowMap(const GlFunctions& gl);
    ~ShadowMap();
    ShadowMap(const ShadowMap&) = delete;
    ShadowMap& operator=(const ShadowMap&) = delete;

    /// Left camera's frame to the map's clip space, for a lamp at `p_CL` that shines along `axis_C`.
    static Eigen::Matrix4d projection(const Eigen::Vector3d& p_CL, const Eigen::Vector3d& axis_C);

    /// Binds the map; draw with `set_pose` before each mesh, then bind another framebuffer.
    void begin() const;
    void set_pose(const Eigen::Matrix4d& X_SM) const;

    GLuint texture() const { return texture_; }

  private:
    const GlFunctions& gl_;
    ShaderProgram program_;
    GLuint framebuffer_ = 0, texture_ = 0;
};

}  // namespace atropos::render
