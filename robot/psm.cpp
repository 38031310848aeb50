#include "robot/psm.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>

namespace atropos::robot {
namespace {

constexpr double kQuarter = std::numbers::pi / 2.0, kTurn = 2.0 * std::numbers::pi;

// dVRK's tooltip_offset: T in DH frame 6.
const Eigen::Matrix3d& R_6T() {
    static const Eigen::Matrix3d R = (Eigen::Matrix3d() << 0, -1, 0, 0, 0, 1, -1, 0, 0).finished();
    return R;
}

// Unit vector u of the wrist-pitch to wrist-yaw link, up to sign: in the plane of the tip and the yaw axis
// z6, perpendicular to z6. False when the tip lies on z6 through the remote centre.
bool wrist_direction(const Eigen::Isometry3d& X_BT, Eigen::Vector3d& u) {
    const Eigen::Vector3d p = X_BT.translation(), z6 = -X_BT.linear().col(0);
    u = p - p.dot(z6) * z6;
    const double length = u.norm();
    u /= length;
    return p.norm() >= 1e-3 && length > 1e-9;
}

}  // namespace

PsmModel psm_classic() {
    return {};
}

PsmModel psm_si() {
    PsmModel model;
    model.insertion_offset_m = 0.4826;
    model.limits = {{-2.964, -1.265, 0.0}, {2.964, 1.301, 0.29}};
    return model;
}

bool is_pose(const Eigen::Isometry3d& X) {
    const Eigen::Matrix3d R = X.linear();
    return X.matrix().allFinite() && (R.transpose() * R - Eigen::Matrix3d::Identity()).norm() < 1e-6 &&
           R.determinant() > 0.0;
}

template <class Vector>
std::string reason(const IkResult<Vector>& r) {
    char text[160] = "";
    const double degrees = r.value * 180.0 / std::numbers::pi;
    switch (r.status) {
        case IkStatus::kOk:
            break;
        case IkStatus::kOutsideLimits:
            if (r.joint == 2)
                std::snprintf(text, sizeof text, "insertion %.1f mm, outside its limits", 1e3 * r.value);
            else
                std::snprintf(text, sizeof text, "%s %.1f deg, outside its limits",
                              kJointNames[static_cast<size_t>(r.joint)].data(), degrees);
            break;
        case IkStatus::kTooShallow:
            std::snprintf(text, sizeof text, "wrist %.1f mm beyond the remote centre, expected at least %.0f",
                          1e3 * r.value, 1e3 * Psm::kSafeDepth_m);
            break;
        case IkStatus::kAtRemoteCentre:
            return "tip at the remote centre, expected beyond it";
        case IkStatus::kNotAPose:
            return "not a finite rigid pose";
        case IkStatus::kNotOnAxis:
            std::snprintf(text, sizeof text, "view %.2f deg off the endoscope's shaft, expected along it",
                          degrees);
    }
    return text;
}
template std::string reason(const IkResult<Joints>&);
template std::string reason(const IkResult<EcmJoints>&);

Psm::Psm(const Tool& tool, const PsmModel& model)
    : tool_(tool), insertion_offset_m_(model.insertion_offset_m) {
    limits_.lower << model.limits.lower, -model.roll_max_rad, -tool.wrist_pitch_max_rad,
        -tool.wrist_yaw_max_rad;
    limits_.upper << model.limits.upper, model.roll_max_rad, tool.wrist_pitch_max_rad, tool.wrist_yaw_max_rad;
    dh_ = {DhRow{1, 0.0, 0.0, kQuarter, false},
           DhRow{-1, 0.0, 0.0, -kQuarter, false},
           DhRow{1, 0.0, -model.insertion_offset_m, 0.0, true},
           DhRow{0, 0.0, tool.shaft_m, 0.0, false},
           DhRow{-1, 0.0, 0.0, -kQuarter, false},
           DhRow{-1, tool.pitch_to_yaw_m, 0.0, -kQuarter, false}};
}

std::array<Eigen::Isometry3d, 6> Psm::frames(const Joints& q) const {
    std::array<Eigen::Isometry3d, 6> X_BF;
    X_BF[0] = dh_[0].pose(q[0]);
    for (size_t i = 1; i < 6; ++i) X_BF[i] = X_BF[i - 1] * dh_[i].pose(q[static_cast<int>(i)]);
    return X_BF;
}

Eigen::Isometry3d Psm::forward(const Joints& q) const {
    Eigen::Isometry3d X = dh_[0].pose(q[0]);
    for (size_t i = 1; i < 6; ++i) X = X * dh_[i].pose(q[static_cast<int>(i)]);
    X.linear() = (X.linear() * R_6T()).eval();
    return X;
}

Eigen::Matrix<double, 6, 6> Psm::jacobian(const Joints& q) const {
    const auto X_BF = frames(q);
    const Eigen::Vector3d p = X_BF[5].translation();
    Eigen::Matrix<double, 6, 6> J;
    for (int i = 0; i < 6; ++i) {
        const Eigen::Isometry3d& X = X_BF[static_cast<size_t>(i)];
        const Eigen::Vector3d z = X.linear().col(2);
        const bool prismatic = dh_[static_cast<size_t>(i)].prismatic;
        J.col(i).head<3>() = prismatic ? z : Eigen::Vector3d(z.cross(p - X.translation()));
        J.col(i).tail<3>() = prismatic ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : z;
    }
    return J;
}

// With the wrist link's direction x5 known, all joints are angles between known axes: the shaft z4 runs from
// the remote centre to the wrist-pitch point, y4 = z5 is the pitch axis, y5 = z6 the yaw axis.
Joints Psm::solve(const Eigen::Isometry3d& X_BT, const Eigen::Vector3d& x5) const {
    const Eigen::Vector3d w = X_BT.translation() - tool_.pitch_to_yaw_m * x5;
    const double depth = w.norm(), across = std::hypot(w.x(), w.z());
    const double s1 = w.x() / across, c1 = -w.z() / across, s2 = -w.y() / depth, c2 = across / depth;
    const Eigen::Vector3d x3(-s1 * s2, -c2, c1 * s2), y3(-c1, 0.0, -s1), z4 = w / depth;
    const Eigen::Vector3d z6 = -X_BT.linear().col(0), z_T = X_BT.linear().col(2);
    const Eigen::Vector3d z5 = x5.cross(z6), x4 = z5.cross(z4);
    Joints q;
    q << std::atan2(w.x(), -w.z()), std::atan2(-w.y(), across), depth + insertion_offset_m_ - tool_.shaft_m,
        std::atan2(-z5.dot(x3), z5.dot(y3)), std::atan2(x5.dot(x4), x5.dot(z4)),
        std::atan2(-z_T.dot(z5), z_T.dot(x5));
    return q;
}

IkResult<Joints> Psm::inverse(const Eigen::Isometry3d& X_BT, const Joints& q_near) const {
    IkResult<Joints> result;
    if (!is_pose(X_BT)) return result;
    Eigen::Vector3d u;
    if (!wrist_direction(X_BT, u)) {
        result.status = IkStatus::kAtRemoteCentre;
        return result;
    }
    Joints& q = result.q;
    q = solve(X_BT, u);
    const double depth = q[2] - insertion_offset_m_ + tool_.shaft_m;
    if (depth < kSafeDepth_m - kLimitSlack) {
        result.status = IkStatus::kTooShallow;
        result.value = depth;
        return result;
    }
    q[3] += kTurn * std::round((q_near[3] - q[3]) / kTurn);
    while (q[3] > limits_.upper[3] + kLimitSlack) q[3] -= kTurn;
    while (q[3] < limits_.lower[3] - kLimitSlack) q[3] += kTurn;
    result.joint = limits_.first_outside(q);
    result.status = result.joint < 0 ? IkStatus::kOk : IkStatus::kOutsideLimits;
    if (result.joint >= 0) result.value = q[result.joint];
    return result;
}

std::vector<Joints> Psm::branches(const Eigen::Isometry3d& X_BT) const {
    std::vector<Joints> all;
    Eigen::Vector3d u;
    if (!is_pose(X_BT) || !wrist_direction(X_BT, u)) return all;
    for (const double sign : {1.0, -1.0}) {
        const Joints q = solve(X_BT, sign * u);
        for (int turn = -1; turn <= 1; ++turn) {
            Joints turned = q;
            turned[3] += kTurn * turn;
            if (turned[3] >= limits_.lower[3] && turned[3] <= limits_.upper[3]) all.push_back(turned);
        }
    }
    return all;
}

std::array<Eigen::Isometry3d, kLinkCount> Psm::link_poses(const Joints& q, double jaw_rad) const {
    const auto X_BF = frames(q);
    const auto turned = [](const Eigen::Isometry3d& X, const Eigen::Matrix3d& R) {
        Eigen::Isometry3d Y = X;
        Y.linear() = X.linear() * R;
        return Y;
    };
    const Eigen::Matrix3d R_4shaft = (Eigen::Matrix3d() << 0, 1, 0, -1, 0, 0, 0, 0, 1).finished();
    const Eigen::Matrix3d R_5wrist = (Eigen::Matrix3d() << 0, 0, 1, 0, 1, 0, -1, 0, 0).finished();
    const Eigen::AngleAxisd half(std::max(jaw_rad, 0.0) / 2.0, Eigen::Vector3d::UnitY());
    const Eigen::Matrix3d R_6jaws = R_6T() * R_TG();
    return {turned(X_BF[3], R_4shaft), turned(X_BF[4], R_5wrist),
            turned(X_BF[5], R_6jaws * half.toRotationMatrix()),
            turned(X_BF[5], R_6jaws * half.inverse().toRotationMatrix())};
}

std::vector<scenes::Capsule> Psm::capsules(const Joints& q, double jaw_rad) const {
    const auto X_BL = link_poses(q, jaw_rad);
    std::vector<scenes::Capsule> all;
    for (size_t i = 0; i < kLinkCount; ++i)
        for (const scenes::Capsule& c : tool_.capsules[i])
            all.push_back({X_BL[i] * c.a, X_BL[i] * c.b, c.radius_m});
    return all;
}

}  // namespace atropos::robot
