#include "render/scene_program.hpp"

#include <cmath>

#include "render/shaders.hpp"

namespace atropos::render {
namespace {

std::string defines(unsigned variant) {
    std::string text;
    if (variant & SceneProgram::kTextured) text += "#define TEXTURED\n";
    if (variant & SceneProgram::kWet) text += "#define WET\n";
    if (variant & SceneProgram::kShadows) text += "#define SHADOWS\n";
    if (variant & SceneProgram::kDistorted) text += "#define DISTORTED\n";
    return text;
}

float f(double value) {
    return static_cast<float>(value);
}

}  // namespace

SceneProgram::SceneProgram(const GlFunctions& gl, unsigned variant)
    : gl_(gl),
      program_(gl, defines(variant), kSceneVertexShader, kSceneFragmentShader),
      pose_(program_.uniform("u_X_EM")),
      intrinsics_(program_.uniform("u_intrinsics")),
      distortion_(program_.uniform("u_distortion")),
      r2_max_(program_.uniform("u_r2_max")),
      depth_range_(program_.uniform("u_depth_range")),
      base_colour_(program_.uniform("u_base_colour")),
      surface_(program_.uniform("u_surface")),
      label_(program_.uniform("u_label")),
      light_position_(program_.uniform("u_light_position")),
      light_axis_(program_.uniform("u_light_axis")),
      light_(program_.uniform("u_light")),
      shadow_(program_.uniform("u_X_SE")) {
    program_.use();
    gl_.Uniform1i(program_.uniform("u_colour_map"), 0);
    gl_.Uniform1i(program_.uniform("u_normal_map"), 1);
    gl_.Uniform1i(program_.uniform("u_shadow_map"), 2);
}

void SceneProgram::set_eye(const Eye& eye, const EndoscopeOptions& options) const {
    // Sample column i shows the image at x = i / s pixels, so that every s-th sample is a pixel's centre:
    // window coordinate s x + 0.5, clip coordinate 2 (s x + 0.5) / (s w) - 1.
    const scenes::Camera& c = eye.camera;
    const double s = options.supersampling;
    gl_.Uniform4f(intrinsics_, f(2.0 * c.fx_px / c.width_px), f(2.0 * c.fy_px / c.height_px),
                  f((2.0 * c.cx_px + 1.0 / s) / c.width_px - 1.0),
                  f((2.0 * c.cy_px + 1.0 / s) / c.height_px - 1.0));
    std::array<float, 8> distortion;
    for (std::size_t i = 0; i < distortion.size(); ++i) distortion[i] = f(c.distortion[i]);
    gl_.Uniform1fv(distortion_, 8, distortion.data());
    gl_.Uniform1f(r2_max_, f(monotonic_r2(c)));
    const double n = options.near_m, far = options.far_m;
    gl_.Uniform2f(depth_range_, f((far + n) / (far - n)), f(-2.0 * far * n / (far - n)));
}

void SceneProgram::set_light(const Light& light, const scenes::StereoRig& rig, const Eye& eye,
                             const Eigen::Matrix4d& X_SC) const {
    const Eigen::Vector3f p = (eye.X_EC * light_position_C(light, rig)).cast<float>();
    const Eigen::Vector3f axis = (eye.X_EC.linear() * light_axis_C(rig)).cast<float>();
    gl_.Uniform3f(light_position_, p.x(), p.y(), p.z());
    gl_.Uniform3f(light_axis_, axis.x(), axis.y(), axis.z());
    gl_.Uniform4f(light_, f(light.intensity * light.reference_m * light.reference_m), f(light.cos_outer),
                  f(1.0 / (light.cos_inner - light.cos_outer)), f(light.ambient));
    const Eigen::Matrix4f X_SE = (X_SC * eye.X_EC.inverse().matrix()).cast<float>();
    gl_.UniformMatrix4fv(shadow_, 1, GL_FALSE, X_SE.data());
}

void SceneProgram::set_item(const scenes::RenderItem& item, const Eigen::Isometry3d& X_EM) const {
    const scenes::Material& m = item.material;
    const Eigen::Matrix4f pose = X_EM.matrix().cast<float>();
    gl_.UniformMatrix4fv(pose_, 1, GL_FALSE, pose.data());
    gl_.Uniform3f(base_colour_, m.base_colour.x(), m.base_colour.y(), m.base_colour.z());
    gl_.Uniform4f(surface_, m.metallic, m.roughness, m.specular_f0, m.wetness);
    gl_.Uniform1ui(label_, static_cast<GLuint>(item.label));
}

Eigen::Vector3d light_position_C(const Light& light, const scenes::StereoRig& rig) {
    return 0.5 * rig.X_RC.inverse().translation() + light.offset_m;
}

Eigen::Vector3d light_axis_C(const scenes::StereoRig& rig) {
    const Eigen::Vector3d right_axis = rig.X_RC.linear().transpose() * Eigen::Vector3d::UnitZ();
    return (Eigen::Vector3d::UnitZ() + right_axis).normalized();
}

double monotonic_r2(const scenes::Camera& camera) {
    constexpr double kMaxRadius = 4.0, kStep = 0.01;  // tan of 76 degrees
    double previous = 0.0;
    for (double r = kStep; r < kMaxRadius; r += kStep) {
        const double distorted = camera.distort({r, 0.0}).x();
        if (distorted <= previous) return (r - 2.0 * kStep) * (r - 2.0 * kStep);
        previous = distorted;
    }
    return kMaxRadius * kMaxRadius;
}

}  // namespace atropos::render
