#pragma once

#include <array>
#include <optional>

#include "tracker/stereo_tracker.hpp"

namespace atropos::experiments {

/// The paper's knot (III-B): an end that an instrument held and let go of, tied. From then on it is fixed
/// where the tracker's own curve ended while it was held, not where anybody measured it.
class KnotEnds {
  public:
    /// Puts fixed ends that were held before to where the curve ended.
    void place(tracker::StereoFrame& frame) const;

    /// The curve that was found in a frame.
    void learn(const tracker::StereoFrame& frame, const scenes::ThreadEstimate& estimate);

  private:
    std::array<std::optional<Eigen::Vector3d>, 2> held_C_;
};

}  // namespace atropos::experiments
