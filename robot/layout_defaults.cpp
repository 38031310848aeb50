#include "robot/layout_defaults.hpp"

#include <cmath>
#include <stdexcept>

namespace atropos::robot {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Isometry3d frame_yz(const Vector3d& p, const Vector3d& y, const Vector3d& z) {
    Isometry3d X = Isometry3d::Identity();
    X.linear() << y.cross(z), y, z;
    X.translation() = p;
    return X;
}

}  // namespace

std::array<Isometry3d, 2> LayoutDefaults::X_WG() const {
    const double s = std::sin(grip_tilt_rad), c = std::cos(grip_tilt_rad), half = 0.5 * grip_distance_m;
    return {frame_yz({-half, 0.0, grip_height_m}, {c, 0.0, -s}, {-s, 0.0, -c}),
            frame_yz({half, 0.0, grip_height_m}, {c, 0.0, s}, {s, 0.0, -c})};
}

Isometry3d LayoutDefaults::X_WS(const Vector3d& p_WS, const Vector3d& tangent_W, const Vector3d& p_WB) {
    const Vector3d y = tangent_W.normalized(), reach = (p_WS - p_WB).normalized();
    const Vector3d across = reach - reach.dot(y) * y;
    if (!(across.norm() > 0.1))
        throw std::invalid_argument("cut: the thread runs along the instrument, expected it across");
    return frame_yz(p_WS, y, across.normalized());
}

Isometry3d LayoutDefaults::X_WS_parked(const Vector3d& p_WB) const {
    return X_WS_parked_at(park_distance_m * p_WB.normalized(), p_WB);
}

Isometry3d LayoutDefaults::X_WS_parked_at(const Vector3d& p_WS, const Vector3d& p_WB) {
    return X_WS(p_WS, Vector3d::UnitX(), p_WB);
}

IkResult<Joints> joints_for(const Psm& psm, const Isometry3d& X_WB, const Isometry3d& X_WF,
                            const Isometry3d& X_TF, const Joints& q_near) {
    return psm.inverse(X_WB.inverse() * X_WF * X_TF.inverse(), q_near);
}

}  // namespace atropos::robot
