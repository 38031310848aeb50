#pragma once

#include <Eigen/Core>
#include <span>

#include "scenes/capsule.hpp"

namespace atropos::robot {

/// What is near an instrument.
struct Neighbourhood {
    double clearance_m = 1.0;  ///< to what comes nearest; 1: nothing is there
    /// Way out of what is nearer than wanted: by axis the farthest that anything asks for to either side, so
    /// that what is between two neighbours goes to the middle.
    Eigen::Vector3d way_out_m = Eigen::Vector3d::Zero();
};

/// `own` and `others` in one frame. Negative clearance where they overlap.
Neighbourhood neighbourhood(std::span<const scenes::Capsule> own, std::span<const scenes::Capsule> others,
                            double wanted_clearance_m);

/// How far an instrument leaves its way for others that come too near: pushed off by them, drawn back to its
/// way as by a spring.
class GiveWay {
  public:
    /// Own choices: holders go at up to 0.05 m/s.
    struct Options {
        double clearance_m = 0.009;  ///< below which it begins
        double push_s = 0.05, back_s = 0.4, smooth_s = 0.02;
        double speed_m_s = 0.08;
    };

    GiveWay() = default;
    explicit GiveWay(const Options& options) : options_(options) {}

    /// One period of the arm later.
    void step(const Neighbourhood& neighbourhood);

    double wanted_clearance_m() const { return options_.clearance_m; }

    const Eigen::Vector3d& offset_m() const { return offset_; }
    bool is_aside() const { return offset_.norm() > 1e-6; }

  private:
    Options options_;
    Eigen::Vector3d offset_ = Eigen::Vector3d::Zero(), rate_ = Eigen::Vector3d::Zero();
};

}  // namespace atropos::robot
