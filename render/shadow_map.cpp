#include "render/shadow_map.hpp"

#include "render/shaders.hpp"

namespace atropos::render {
namespace {

constexpr int kSize_px = 2048;
constexpr double kTanHalfAngle = 0.80, kNear_m = 0.01, kFar_m = 0.5;

}  // namespace

ShadowMap::ShadowMap(const GlFunctions& gl)
    : gl_(gl), program_(gl, "", kShadowVertexShader, kShadowFragmentShader) {
    gl_.GenTextures(1, &texture_);
    gl_.BindTexture(GL_TEXTURE_2D, texture_);
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, kSize_px, kSize_px, 0, GL_DEPTH_COMPONENT,
                   GL_FLOAT, nullptr);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    gl_.GenFramebuffers(1, &framebuffer_);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, texture_, 0);
    gl_.DrawBuffer(GL_NONE);
    gl_.ReadBuffer(GL_NONE);
}

ShadowMap::~ShadowMap() {
    gl_.DeleteTextures(1, &texture_);
    gl_.DeleteFramebuffers(1, &framebuffer_);
}

Eigen::Matrix4d ShadowMap::projection(const Eigen::Vector3d& p_CL, const Eigen::Vector3d& axis_C) {
    const Eigen::Matrix3d R_LC =
        Eigen::Quaterniond::FromTwoVectors(axis_C, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    Eigen::Matrix4d X_LC = Eigen::Matrix4d::Identity();
    X_LC.topLeftCorner<3, 3>() = R_LC;
    X_LC.topRightCorner<3, 1>() = -R_LC * p_CL;
    Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
    clip(0, 0) = clip(1, 1) = 1.0 / kTanHalfAngle;
    clip(2, 2) = (kFar_m + kNear_m) / (kFar_m - kNear_m);
    clip(2, 3) = -2.0 * kFar_m * kNear_m / (kFar_m - kNear_m);
    clip(3, 2) = 1.0;
    return clip * X_LC;
}

void ShadowMap::begin() const {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    gl_.Disable(GL_SCISSOR_TEST);
    gl_.Viewport(0, 0, kSize_px, kSize_px);
    const float far = 1.0f;
    gl_.ClearBufferfv(GL_DEPTH, 0, &far);
    program_.use();
}

void ShadowMap::set_pose(const Eigen::Matrix4d& X_SM) const {
    const Eigen::Matrix4f pose = X_SM.cast<float>();
    gl_.UniformMatrix4fv(program_.uniform("u_X_SM"), 1, GL_FALSE, pose.data());
}

}  // namespace atropos::render
