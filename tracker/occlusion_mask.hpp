#pragma once

#include <Eigen/Core>
#include <span>

#include "scenes/capsule.hpp"

namespace atropos::tracker {

/// What instruments hide from one eye, by their measured capsules: seen exactly, for any camera, by the
/// viewing ray and not by a picture. A hidden place gives no data, which is not the same as data against the
/// curve.
class OcclusionMask {
  public:
    /// `eye_C`: centre of projection. `margin_m`: what the poses may be wrong by; capsules grow by it.
    /// `behind_m`: an instrument that much behind a point no longer disturbs it.
    OcclusionMask(std::span<const scenes::Capsule> instruments_C, const Eigen::Vector3d& eye_C,
                  double margin_m, double behind_m)
        : instruments_(instruments_C), eye_C_(eye_C), margin_m_(margin_m), behind_m_(behind_m) {}

    bool empty() const { return instruments_.empty(); }

    /// Whether an instrument lies before, at, or close behind a point in C.
    bool hides(const Eigen::Vector3d& p_C) const;

  private:
    std::span<const scenes::Capsule> instruments_;
    Eigen::Vector3d eye_C_;
    double margin_m_;
    double behind_m_;
};

}  // namespace atropos::tracker
