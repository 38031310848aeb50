#pragma once

#include <Eigen/Core>

#include "robot/scissors_input.hpp"

namespace atropos::robot {

/// Fuses what images say of an instrument's offset with what the calibration promised. The offset
/// wanders as the arm moves, because cables and hand-eye rotation act differently in each pose, but never
/// beyond what the calibration promised (Ornstein-Uhlenbeck process over the way).
class OffsetFilter {
  public:
    struct Options {
        double prior_sigma_m = 0.0011;    ///< of one axis
        double forget_m = 0.15;           ///< way over which the offset becomes another one
        double creep_m_s = 0.0005;        ///< standing still counts as this much way
        double floor_lateral_m = 0.0001;  ///< what averaging cannot remove
        double floor_depth_m = 0.0003;
        double max_surprise = 25.0;  ///< squared, three degrees of freedom; beyond: an outlier
    };

    explicit OffsetFilter(const Options& options);

    /// The blade has moved from where it was asked about last.
    void travel(double way_m, double dt_s);

    /// `p_C` is where the instrument is, for the viewing ray. False: refused as an outlier.
    bool update(const InstrumentOffset& measured, const Eigen::Vector3d& p_C);

    const Eigen::Vector3d& offset_C_m() const { return offset_; }
    /// m^2, with the floor.
    Eigen::Matrix3d covariance(const Eigen::Vector3d& p_C) const;

  private:
    Options options_;
    Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();
    Eigen::Matrix3d P_;
};

/// Covariance of a point seen by the left eye: sigmas across and along its viewing ray.
Eigen::Matrix3d ray_covariance(const Eigen::Vector3d& p_C, double sigma_lateral_m, double sigma_depth_m);

}  // namespace atropos::robot
