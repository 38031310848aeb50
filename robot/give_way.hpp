#pragma once

#include <Eigen/Core>
#include <span>

#include "scenes/capsule.hpp"

namespace atropos::robot {

/// What comes nearest to an instrument.
struct Nearest {
    double clearance_m = 1.0;                        ///< 1: nothing is there
    Eigen::Vector3d away = Eigen::Vector3d::Zero();  ///< unit vector from it to the instrument
};

/// `own` and `others` in one frame. Negative clearance where they overlap.
Nearest nearest(std::span<const scenes::Capsule> own, std::span<const scenes::Capsule> others);

/// How far an instrument leaves its way for others that come too near: pushed off by what is nearest, drawn
/// back to its way as by a spring once there is room.
class GiveWay {
  public:
    /// Own choices: holders go at up to 0.05 m/s.
    struct Options {
        double from_m = 0.009;  ///< clearance at which it begins
        double push_s = 0.04, back_s = 0.4, smooth_s = 0.02;
        double speed_m_s = 0.08;
    };

    GiveWay() = default;
    explicit GiveWay(const Options& options) : options_(options) {}

    /// One period of the arm later.
    void step(const Nearest& nearest);

    const Eigen::Vector3d& offset_m() const { return offset_; }
    bool is_aside() const { return offset_.norm() > 1e-6; }

  private:
    Options options_;
    Eigen::Vector3d offset_ = Eigen::Vector3d::Zero(), rate_ = Eigen::Vector3d::Zero();
};

}  // namespace atropos::robot
