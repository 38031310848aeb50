#pragma once

#include <Eigen/Geometry>
#include <array>

namespace atropos::scenes {

/// Pinhole camera with OpenCV's rational distortion. Pixel centres at integers, x right, y down, z forward.
struct Camera {
    int width_px = 0;
    int height_px = 0;
    double fx_px = 0.0;
    double fy_px = 0.0;
    double cx_px = 0.0;
    double cy_px = 0.0;
    std::array<double, 8> distortion{};  ///< k1 k2 p1 p2 k3 k4 k5 k6, OpenCV's order; all 0 = none

    Eigen::Matrix3d K() const;
    bool is_distorted() const;

    /// Pixel of a point in this camera's frame (m), with distortion. Undefined for z <= 0: check first.
    Eigen::Vector2d project(const Eigen::Vector3d& p) const;

    /// As `project`; `J` becomes d pixel / d p (px per m).
    Eigen::Vector2d project(const Eigen::Vector3d& p, Eigen::Matrix<double, 2, 3>& J) const;

    /// Distorted normalised coordinates of undistorted ones (x/z, y/z); `J` (optional) their derivative.
    Eigen::Vector2d distort(const Eigen::Vector2d& xn, Eigen::Matrix2d* J = nullptr) const;

    /// Undistorted normalised coordinates (x/z, y/z) of a pixel, to 1e-12 by Newton's method.
    Eigen::Vector2d normalised(const Eigen::Vector2d& pixel) const;

    /// Unit direction of the viewing ray through a pixel.
    Eigen::Vector3d ray(const Eigen::Vector2d& pixel) const;

    bool contains(const Eigen::Vector2d& pixel) const;

    /// The same camera on images `factor` times as large (0.5: half size); pixel centres stay at integers.
    Camera scaled(double factor) const;
};

}  // namespace atropos::scenes
