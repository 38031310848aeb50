#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/camera.hpp"

namespace atropos::scenes {

/// 3x4 projection matrix: homogeneous pixel of a homogeneous point in C (m).
using ProjectionMatrix = Eigen::Matrix<double, 3, 4>;

/// Rectifying rotations and projections of a rig, with OpenCV's names; P2 and Q with the baseline in metres.
struct Rectification {
    Eigen::Matrix3d R1 = Eigen::Matrix3d::Identity();  ///< C to the rectified left frame
    Eigen::Matrix3d R2 = Eigen::Matrix3d::Identity();  ///< R to the rectified right frame
    ProjectionMatrix P1 = ProjectionMatrix::Zero();
    ProjectionMatrix P2 = ProjectionMatrix::Zero();
    Eigen::Matrix4d Q = Eigen::Matrix4d::Zero();  ///< (u, v, disparity, 1) to a homogeneous point
};

/// Two calibrated cameras. C is the left camera's frame, R the right one's.
struct StereoRig {
    Camera left;
    Camera right;
    Eigen::Isometry3d X_RC = Eigen::Isometry3d::Identity();  ///< p_R = X_RC * p_C; OpenCV's R and T (m)

    /// Distortion left out.
    ProjectionMatrix P_left() const;
    ProjectionMatrix P_right() const;

    Eigen::Vector2d project_left(const Eigen::Vector3d& p_C) const { return left.project(p_C); }
    Eigen::Vector2d project_right(const Eigen::Vector3d& p_C) const { return right.project(X_RC * p_C); }

    /// The point in C nearest to both viewing rays; nullopt when they are parallel or meet behind a camera.
    std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& left_px,
                                             const Eigen::Vector2d& right_px) const;

    double baseline_m() const { return X_RC.translation().norm(); }

    /// Size of a pixel across the view at depth z, and the depth that one pixel of disparity is worth there.
    double m_per_px(double z_m) const { return z_m / left.fx_px; }
    double m_per_disparity_px(double z_m) const { return z_m * z_m / (left.fx_px * baseline_m()); }

    /// Rows of both eyes agree after it; both share focal length and principal point (zero disparity at
    /// infinity).
    Rectification rectification() const;

    StereoRig scaled(double factor) const;
};

/// A parallel rig without distortion: principal point in the image's centre.
StereoRig parallel_rig(int width_px, int height_px, double focal_px, double baseline_m);

/// A rig by name, with where its numbers come from.
struct RigPreset {
    std::string_view name;
    std::string_view source;
    double working_distance_m;
    StereoRig rig;
};
const std::vector<RigPreset>& rig_presets();

/// Throws std::invalid_argument that lists the known names.
const RigPreset& rig_preset(std::string_view name);

}  // namespace atropos::scenes
