#include "scenes/stereo_rig.hpp"

#include <Eigen/LU>
#include <cmath>

namespace atropos::scenes {

ProjectionMatrix StereoRig::P_left() const {
    ProjectionMatrix P = ProjectionMatrix::Zero();
    P.leftCols<3>() = left.K();
    return P;
}

ProjectionMatrix StereoRig::P_right() const {
    return right.K() * X_RC.matrix().topRows<3>();
}

std::optional<Eigen::Vector3d> StereoRig::unproject(const Eigen::Vector2d& left_px,
                                                    const Eigen::Vector2d& right_px) const {
    const Eigen::Isometry3d X_CR = X_RC.inverse();
    const Eigen::Vector3d a = left.normalised(left_px).homogeneous();
    const Eigen::Vector3d b = X_CR.linear() * right.normalised(right_px).homogeneous();
    const Eigen::Vector3d o = X_CR.translation();
    // Midpoint of the shortest segment between z_left * a and o + z_right * b.
    Eigen::Matrix2d A;
    A << a.dot(a), -a.dot(b), -a.dot(b), b.dot(b);
    if (std::abs(A.determinant()) < 1e-14 * A(0, 0) * A(1, 1)) return std::nullopt;
    const Eigen::Vector2d z = A.inverse() * Eigen::Vector2d(a.dot(o), -b.dot(o));
    if (!(z.x() > 0.0 && z.y() > 0.0)) return std::nullopt;
    return 0.5 * (z.x() * a + o + z.y() * b);
}

Rectification StereoRig::rectification() const {
    // Bouguet: turn each camera by half of the rotation between them, then both so that the baseline lies
    // along x.
    const Eigen::AngleAxisd turn(X_RC.linear());
    const Eigen::Matrix3d half = Eigen::AngleAxisd(0.5 * turn.angle(), turn.axis()).toRotationMatrix();
    const Eigen::Vector3d t = half.transpose() * X_RC.translation();  // in the half-way frame
    const Eigen::Vector3d x =
        t.x() < 0.0 ? Eigen::Vector3d(-t.normalized()) : Eigen::Vector3d(t.normalized());
    const Eigen::Matrix3d align =
        Eigen::Quaterniond::FromTwoVectors(x, Eigen::Vector3d::UnitX()).toRotationMatrix();

    Rectification r;
    r.R1 = align * half;
    r.R2 = align * half.transpose();
    const double f = 0.5 * (left.fy_px + right.fy_px);
    const double cx = 0.5 * (left.cx_px + right.cx_px), cy = 0.5 * (left.cy_px + right.cy_px);
    Eigen::Matrix3d K;
    K << f, 0.0, cx, 0.0, f, cy, 0.0, 0.0, 1.0;
    r.P1.leftCols<3>() = K;
    r.P2 = r.P1;
    const double tx = (align * t).x();
    r.P2(0, 3) = f * tx;
    r.Q << 1.0, 0.0, 0.0, -cx, 0.0, 1.0, 0.0, -cy, 0.0, 0.0, 0.0, f, 0.0, 0.0, -1.0 / tx, 0.0;
    return r;
}

StereoRig StereoRig::scaled(double factor) const {
    return {left.scaled(factor), right.scaled(factor), X_RC};
}

StereoRig parallel_rig(int width_px, int height_px, double focal_px, double baseline_m) {
    StereoRig rig;
    rig.left = {width_px, height_px, focal_px, focal_px, 0.5 * (width_px - 1), 0.5 * (height_px - 1), {}};
    rig.right = rig.left;
    rig.X_RC.translation() = Eigen::Vector3d(-baseline_m, 0.0, 0.0);
    return rig;
}

}  // namespace atropos::scenes
