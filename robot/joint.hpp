#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <string_view>

namespace atropos::robot {

/// Joint values of a PSM: yaw, pitch (rad), insertion (m), roll, wrist pitch, wrist yaw (rad).
using Joints = Eigen::Matrix<double, 6, 1>;
/// Joint values of an ECM: yaw, pitch (rad), insertion (m), roll (rad).
using EcmJoints = Eigen::Matrix<double, 4, 1>;
/// Linear velocity of a point over angular velocity, both in one frame; m/s and rad/s.
using Twist = Eigen::Matrix<double, 6, 1>;

/// CRTK's names of the joints; a PSM has all, an ECM the first four.
constexpr std::array<std::string_view, 6> kJointNames = {"yaw",  "pitch",       "insertion",
                                                         "roll", "wrist_pitch", "wrist_yaw"};

/// Rounding may carry a joint this far past its limit before it counts as outside (rad or m).
constexpr double kLimitSlack = 1e-9;

template <class Vector>
struct Range {
    Vector lower;
    Vector upper;

    /// Index of the first value outside by more than `slack`, or -1.
    int first_outside(const Vector& q, double slack = kLimitSlack) const {
        for (int i = 0; i < q.size(); ++i)
            if (!(q[i] >= lower[i] - slack && q[i] <= upper[i] + slack)) return i;
        return -1;
    }
};

}  // namespace atropos::robot
