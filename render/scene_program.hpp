#pragma once

#include <Eigen/Geometry>

#include "render/endoscope_options.hpp"
#include "render/light.hpp"
#include "render/shader_program.hpp"
#include "scenes/render_item.hpp"
#include "scenes/stereo_rig.hpp"

namespace atropos::render {

/// One eye of the rig: its camera, its pose, and which half of the framebuffer it fills.
struct Eye {
    scenes::Camera camera;
    Eigen::Isometry3d X_EC;
    int index;
};

/// The scene shader in one of its variants, with the uniforms' places.
class SceneProgram {
  public:
    enum Variant : unsigned { kTextured = 1, kWet = 2, kShadows = 4, kDistorted = 8, kVariants = 16 };

    SceneProgram(const GlFunctions& gl, unsigned variant);

    void use() const { program_.use(); }
    void set_eye(const Eye& eye, const EndoscopeOptions& options) const;
    void set_light(const Light& light, const scenes::StereoRig& rig, const Eye& eye,
                   const Eigen::Matrix4d& X_SC) const;
    void set_item(const scenes::RenderItem& item, const Eigen::Isometry3d& X_EM) const;

  private:
    const GlFunctions& gl_;
    ShaderProgram program_;
    GLint pose_, intrinsics_, distortion_, r2_max_, depth_range_;
    GLint base_colour_, surface_, label_, light_position_, light_axis_, light_, shadow_;
};

/// Lamp's place and direction in the left camera's frame.
Eigen::Vector3d light_position_C(const Light& light, const scenes::StereoRig& rig);
Eigen::Vector3d light_axis_C(const scenes::StereoRig& rig);

/// Squared radius (normalised) up to which a camera's distortion grows outwards.
double monotonic_r2(const scenes::Camera& camera);

}  // namespace atropos::render
