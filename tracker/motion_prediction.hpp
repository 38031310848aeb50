#pragma once

#include <Eigen/Core>
#include <array>

namespace atropos::tracker {

/// What a thread's control points do without being looked at: the ends' motion carries them along, linearly
/// in u; half of what they did beyond that goes on.
struct MotionPrediction {
    Eigen::Matrix3Xd velocity_m_s;  ///< beyond what the ends' motion explains; 3 x K

    /// Where `Q` is after `dt_s` in which the ends moved by `moved_m`.
    void predict(const Eigen::Matrix3Xd& Q, const std::array<Eigen::Vector3d, 2>& moved_m, double dt_s,
                 Eigen::Matrix3Xd& expected) const;

    /// What was found where `expected` was predicted `dt_s` > 0 before. What leapt is taken to be at rest.
    void follow(const Eigen::Matrix3Xd& found, const Eigen::Matrix3Xd& expected, double dt_s);
};

}  // namespace atropos::tracker
