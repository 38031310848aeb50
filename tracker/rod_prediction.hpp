#pragma once

#include <Eigen/Core>
#include <array>

#include "tracker/cubic_basis.hpp"
#include "tracker/light_rod.hpp"

namespace atropos::tracker {

/// A predicted curve made one that the thread can have: as long everywhere as it was, hung by the ends that
/// were measured.
class RodPrediction {
  public:
    /// `gravity_C`: its direction; zero = unknown.
    RodPrediction(const CubicBasis& basis, const Eigen::Vector3d& gravity_C);

    /// `Q`: the last curve (3 x K, in C, m), `expected`: where it is predicted after `dt_s`; `held` ends
    /// stay there.
    void correct(const Eigen::Matrix3Xd& Q, LightRod::Held held, double dt_s,
                 Eigen::Matrix3Xd& expected) const;

  private:
    LightRod rod_;
    Eigen::Vector3d gravity_m_s2_;
    Eigen::MatrixXd basis_;  ///< nodes by control points
    Eigen::MatrixXd fit_;    ///< and back, in least squares; the ends stay the ends
};

}  // namespace atropos::tracker
