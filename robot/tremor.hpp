#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "robot/smooth_random.hpp"

namespace atropos::robot {

/// Hand tremor of two hands: smooth noise of 8 to 12 Hz. 0.03 mm RMS is what is left at a teleoperated tip.
class Tremor {
  public:
    Tremor() = default;

    /// `rms_m` per axis; drawn from the stream "motion.tremor".
    Tremor(double rms_m, std::uint64_t seed);

    /// Displacement of hand 0 or 1.
    Eigen::Vector3d at(size_t hand, double time_s) const;

  private:
    std::array<std::array<SmoothRandom, 3>, 2> hands_;
};

}  // namespace atropos::robot
