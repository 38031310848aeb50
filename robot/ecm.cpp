#include "robot/ecm.hpp"

#include <cmath>
#include <numbers>

namespace atropos::robot {
namespace {

constexpr double kQuarter = std::numbers::pi / 2.0;
constexpr double kInsertionOffset_m = 0.3822, kShaft_m = 0.3829, kShaftRadius_m = 0.006;

}  // namespace

Ecm::Ecm(Scope scope) {
    limits_.lower << -1.5708, -0.76794, 0.0, -1.552;
    limits_.upper << 1.5708, 1.1344, 0.255, 1.552;
    dh_ = {DhRow{1, 0.0, 0.0, kQuarter, false}, DhRow{-1, 0.0, 0.0, -kQuarter, false},
           DhRow{1, 0.0, -kInsertionOffset_m, 0.0, true}, DhRow{0, 0.0, kShaft_m, 0.0, false}};
    R_4T_ << 0, 1, 0, -1, 0, 0, 0, 0, 1;
    const double tilt = scope == Scope::kStraight ? 0.0 : (scope == Scope::kUp30 ? -1.0 : 1.0);
    if (tilt != 0.0)
        R_4T_ = R_4T_ * Eigen::AngleAxisd(tilt * std::numbers::pi / 6.0, Eigen::Vector3d::UnitX());
}

std::array<Eigen::Isometry3d, 4> Ecm::frames(const EcmJoints& q) const {
    std::array<Eigen::Isometry3d, 4> X_BF;
    X_BF[0] = dh_[0].pose(q[0]);
    for (size_t i = 1; i < 4; ++i) X_BF[i] = X_BF[i - 1] * dh_[i].pose(q[static_cast<int>(i)]);
    return X_BF;
}

Eigen::Isometry3d Ecm::forward(const EcmJoints& q) const {
    Eigen::Isometry3d X = frames(q)[3];
    X.linear() = (X.linear() * R_4T_).eval();
    return X;
}

Eigen::Matrix<double, 6, 4> Ecm::jacobian(const EcmJoints& q) const {
    const auto X_BF = frames(q);
    const Eigen::Vector3d p = X_BF[3].translation();
    Eigen::Matrix<double, 6, 4> J;
    for (int i = 0; i < 4; ++i) {
        const Eigen::Isometry3d& X = X_BF[static_cast<size_t>(i)];
        const Eigen::Vector3d z = X.linear().col(2);
        const bool prismatic = i == 2;
        J.col(i).head<3>() = prismatic ? z : Eigen::Vector3d(z.cross(p - X.translation()));
        J.col(i).tail<3>() = prismatic ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : z;
    }
    return J;
}

IkResult<EcmJoints> Ecm::inverse(const Eigen::Vector3d& p, double roll_rad) const {
    IkResult<EcmJoints> result;
    if (!p.allFinite() || !std::isfinite(roll_rad)) return result;
    if (p.norm() < 1e-3) {
        result.status = IkStatus::kAtRemoteCentre;
        return result;
    }
    const double across = std::hypot(p.x(), p.z());
    result.q << std::atan2(p.x(), -p.z()), std::atan2(-p.y(), across),
        p.norm() + kInsertionOffset_m - kShaft_m, roll_rad;
    result.joint = limits_.first_outside(result.q);
    result.status = result.joint < 0 ? IkStatus::kOk : IkStatus::kOutsideLimits;
    if (result.joint >= 0) result.value = result.q[result.joint];
    return result;
}

IkResult<EcmJoints> Ecm::inverse(const Eigen::Isometry3d& X_BT) const {
    if (!is_pose(X_BT)) return {};
    IkResult<EcmJoints> result = inverse(Eigen::Vector3d(X_BT.translation()), 0.0);
    if (result.status == IkStatus::kAtRemoteCentre) return result;
    const Eigen::Matrix3d R_34 =
        frames({result.q[0], result.q[1], result.q[2], 0.0})[3].linear().transpose() * X_BT.linear() *
        R_4T_.transpose();
    const double off_axis = std::hypot(R_34(0, 2), R_34(1, 2));
    if (off_axis > 1e-6 || R_34(2, 2) < 0.0) {
        result.status = IkStatus::kNotOnAxis;
        result.value = std::atan2(off_axis, R_34(2, 2));
        return result;
    }
    return inverse(Eigen::Vector3d(X_BT.translation()), std::atan2(R_34(1, 0), R_34(0, 0)));
}

scenes::Capsule Ecm::capsule(const EcmJoints& q) const {
    const auto X_BF = frames(q);
    return {X_BF[2].translation(), X_BF[3].translation(), kShaftRadius_m};
}

}  // namespace atropos::robot
