#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "robot/dh.hpp"
#include "robot/joint.hpp"
#include "robot/tool.hpp"

namespace atropos::robot {

/// First three joints of a patient-side manipulator (dVRK share/kinematic/PSM.json).
struct PsmModel {
    double insertion_offset_m = 0.4318;  ///< DH d3 = insertion - offset
    Range<Eigen::Vector3d> limits{{-1.588, -0.925025, 0.0}, {1.588, 0.925025, 0.24}};
    double roll_max_rad = 4.53786;
};
PsmModel psm_classic();
PsmModel psm_si();

enum class IkStatus {
    kOk,
    kOutsideLimits,   ///< joint `joint` of `q` is beyond its limit
    kTooShallow,      ///< the wrist is less than 45 mm beyond the remote centre
    kAtRemoteCentre,  ///< within 1 mm of the remote centre, or on the wrist's own axis through it
    kNotAPose,        ///< not finite, or not a rotation
    kNotOnAxis,       ///< ECM: the view does not lie along the shaft
};

template <class Vector>
struct IkResult {
    IkStatus status = IkStatus::kNotAPose;
    Vector q = Vector::Zero();  ///< solution; for kOutsideLimits the one outside
    int joint = -1;
    double value = 0.0;  ///< what broke the rule: joint value (rad or m) or depth (m)
    explicit operator bool() const { return status == IkStatus::kOk; }
};

/// Why the pose was refused, on one line; empty when it was not.
template <class Vector>
std::string reason(const IkResult<Vector>& result);

/// Kinematics of a PSM with an instrument. B: base, its origin the remote centre, shaft along -z at zero.
/// T: tip as dVRK defines it, on the wrist-yaw axis, z distal.
class Psm {
  public:
    static constexpr double kSafeDepth_m = 0.045;  ///< dVRK SafeDistanceFromRCM

    explicit Psm(const Tool& tool, const PsmModel& model = {});

    const Tool& tool() const { return tool_; }
    const Range<Joints>& limits() const { return limits_; }

    /// X_BT.
    Eigen::Isometry3d forward(const Joints& q) const;

    /// DH frames 1..6 in B.
    std::array<Eigen::Isometry3d, 6> frames(const Joints& q) const;

    /// d(tip position; rotation) / dq in B, (m, rad) per (rad or m).
    Eigen::Matrix<double, 6, 6> jacobian(const Joints& q) const;

    /// Closed-form inverse: the one solution inside the limits, its roll nearest to `q_near`'s. Poses outside
    /// are refused, never approximated.
    IkResult<Joints> inverse(const Eigen::Isometry3d& X_BT, const Joints& q_near = Joints::Zero()) const;

    /// Both wrist branches with every roll turn inside the roll limits, other limits unchecked. The second
    /// branch bends the wrist by more than 90 degrees.
    std::vector<Joints> branches(const Eigen::Isometry3d& X_BT) const;

    /// Poses of shaft, wrist and jaws in B. A negative jaw angle squeezes: the jaws stay shut.
    std::array<Eigen::Isometry3d, kLinkCount> link_poses(const Joints& q, double jaw_rad) const;

    /// All capsules of the instrument at this configuration, in B.
    std::vector<scenes::Capsule> capsules(const Joints& q, double jaw_rad) const;

  private:
    Joints solve(const Eigen::Isometry3d& X_BT, const Eigen::Vector3d& x5) const;

    Tool tool_;
    double insertion_offset_m_;
    Range<Joints> limits_;
    std::array<DhRow, 6> dh_;
};

/// True when the pose is finite and its rotation orthonormal to 1e-6.
bool is_pose(const Eigen::Isometry3d& X);

}  // namespace atropos::robot
