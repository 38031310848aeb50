#pragma once

#include <Eigen/Geometry>
#include <array>

#include "robot/offset_filter.hpp"
#include "robot/psm_arm.hpp"
#include "robot/scissors_options.hpp"

namespace atropos::robot {

/// Where the blades are, from what was commanded, what was measured a little ago, and the offset seen in
/// images. In C.
class BladeBelief {
  public:
    BladeBelief(const ScissorsOptions& options, const Tool& tool, const Eigen::Isometry3d& X_CB);

    /// Once a period: now, the set-points' tip pose, and the newest measurement.
    void observe(double time_s, const Eigen::Isometry3d& X_BT_setpoint, const Measured<ArmState>& measured);

    /// An offset seen in images; false when refused as an outlier.
    bool observe(const InstrumentOffset& offset);

    /// Blade point now, offset included.
    Eigen::Isometry3d X_CS() const;

    const Eigen::Vector3d& offset_C_m() const { return offset_.offset_C_m(); }
    Eigen::Matrix3d covariance() const { return offset_.covariance(X_CS_.translation()); }

    /// Measured minus commanded blade point, at the time of the measurement.
    const Eigen::Vector3d& lag_C_m() const { return lag_; }
    /// Of the set-points' blade point, over the last hundredth of a second.
    double speed_m_s() const;
    /// Sigma of its changes in the last tenths of a second, of one axis.
    double mechanics_m() const;

  private:
    struct Sample {
        double time_s;
        Eigen::Vector3d p_C;
    };
    static constexpr size_t kHistory = 256;
    Eigen::Vector3d setpoint_at(double time_s) const;

    Eigen::Isometry3d X_TS_, X_CB_;
    OffsetFilter offset_;
    Eigen::Isometry3d X_CS_ = Eigen::Isometry3d::Identity();  // of set-points
    std::array<Sample, kHistory> history_{};
    size_t head_ = 0, count_ = 0;
    double measured_time_s_ = -1e9;
    Eigen::Vector3d lag_ = Eigen::Vector3d::Zero(), mean_lag_ = Eigen::Vector3d::Zero();
    double lag_variance_m2_ = 0.0;
};

}  // namespace atropos::robot
