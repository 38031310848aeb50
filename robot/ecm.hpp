#pragma once

#include "robot/psm.hpp"

namespace atropos::robot {

enum class Scope { kStraight, kUp30, kDown30 };

/// Kinematics of the endoscope arm (dVRK share/kinematic/ECM.json). T: middle between the lenses, z along the
/// view, x left and y up as the surgeon sees them.
class Ecm {
  public:
    explicit Ecm(Scope scope = Scope::kStraight);

    const Range<EcmJoints>& limits() const { return limits_; }

    /// X_BT.
    Eigen::Isometry3d forward(const EcmJoints& q) const;

    /// d(tip position; rotation) / dq in B.
    Eigen::Matrix<double, 6, 4> jacobian(const EcmJoints& q) const;

    /// Four joints reach only poses whose shaft passes through the remote centre (to 1e-6 rad); others are
    /// refused.
    IkResult<EcmJoints> inverse(const Eigen::Isometry3d& X_BT) const;

    /// Joints that put the tip at `p_BT`, with the given roll.
    IkResult<EcmJoints> inverse(const Eigen::Vector3d& p_BT, double roll_rad = 0.0) const;

    /// The 12 mm shaft, in B. Its round end stands 6 mm before the flat lens face.
    scenes::Capsule capsule(const EcmJoints& q) const;

  private:
    std::array<Eigen::Isometry3d, 4> frames(const EcmJoints& q) const;

    Range<EcmJoints> limits_;
    std::array<DhRow, 4> dh_;
    Eigen::Matrix3d R_4T_;
};

}  // namespace atropos::robot
