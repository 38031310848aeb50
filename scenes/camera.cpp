#include "scenes/camera.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace atropos::scenes {

Eigen::Matrix3d Camera::K() const {
    Eigen::Matrix3d K;
    K << fx_px, 0.0, cx_px, 0.0, fy_px, cy_px, 0.0, 0.0, 1.0;
    return K;
}

bool Camera::is_distorted() const {
    return std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0.0; });
}

Eigen::Vector2d Camera::distort(const Eigen::Vector2d& xn, Eigen::Matrix2d* J) const {
    const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = distortion;
    const double x = xn.x(), y = xn.y(), r2 = x * x + y * y;
    const double numerator = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    const double denominator = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6));
    const double radial = numerator / denominator;
    if (J) {
        const double d_numerator = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);
        const double d_denominator = k4 + r2 * (2.0 * k5 + r2 * 3.0 * k6);
        const double d_radial = (d_numerator - radial * d_denominator) / denominator;  // by r2
        (*J)(0, 0) = radial + 2.0 * x * x * d_radial + 2.0 * p1 * y + 6.0 * p2 * x;
        (*J)(0, 1) = 2.0 * x * y * d_radial + 2.0 * p1 * x + 2.0 * p2 * y;
        (*J)(1, 0) = (*J)(0, 1);
        (*J)(1, 1) = radial + 2.0 * y * y * d_radial + 6.0 * p1 * y + 2.0 * p2 * x;
    }
    return {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
}

Eigen::Vector2d Camera::project(const Eigen::Vector3d& p) const {
    const Eigen::Vector2d d = distort({p.x() / p.z(), p.y() / p.z()});
    return {fx_px * d.x() + cx_px, fy_px * d.y() + cy_px};
}

Eigen::Vector2d Camera::project(const Eigen::Vector3d& p, Eigen::Matrix<double, 2, 3>& J) const {
    const double inverse_z = 1.0 / p.z();
    const Eigen::Vector2d xn = p.head<2>() * inverse_z;
    Eigen::Matrix2d D;
    const Eigen::Vector2d d = distort(xn, &D);
    D.row(0) *= fx_px;
    D.row(1) *= fy_px;
    J.leftCols<2>() = D * inverse_z;
    J.col(2) = -(D * xn) * inverse_z;
    return {fx_px * d.x() + cx_px, fy_px * d.y() + cy_px};
}

Eigen::Vector2d Camera::normalised(const Eigen::Vector2d& pixel) const {
    const Eigen::Vector2d target{(pixel.x() - cx_px) / fx_px, (pixel.y() - cy_px) / fy_px};
    if (!is_distorted()) return target;
    Eigen::Vector2d xn = target;
    for (int i = 0; i < 30; ++i) {
        Eigen::Matrix2d J;
        const Eigen::Vector2d error = distort(xn, &J) - target;
        const Eigen::Vector2d step = J.inverse() * error;
        if (!step.allFinite()) break;
        xn -= step;
        if (step.squaredNorm() < 1e-28) break;
    }
    return xn;
}

Eigen::Vector3d Camera::ray(const Eigen::Vector2d& pixel) const {
    return normalised(pixel).homogeneous().normalized();
}

bool Camera::contains(const Eigen::Vector2d& pixel) const {
    return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < width_px - 0.5 &&
           pixel.y() < height_px - 0.5;
}

Camera Camera::scaled(double factor) const {
    Camera c = *this;
    c.width_px = static_cast<int>(std::lround(width_px * factor));
    c.height_px = static_cast<int>(std::lround(height_px * factor));
    c.fx_px *= factor;
    c.fy_px *= factor;
    c.cx_px = (cx_px + 0.5) * factor - 0.5;
    c.cy_px = (cy_px + 0.5) * factor - 0.5;
    return c;
}

}  // namespace atropos::scenes
