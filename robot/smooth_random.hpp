#pragma once

#include <array>

#include "scenes/random_stream.hpp"

namespace atropos::robot {

/// A smooth random function of time with a hard bound: a sum of three sinusoids with random frequencies and
/// phases. Its RMS is 0.41 of the bound.
class SmoothRandom {
  public:
    SmoothRandom() = default;

    /// Frequencies uniform in [low, high] (rad/s).
    SmoothRandom(scenes::RandomStream& random, double bound, double low_rad_s, double high_rad_s);

    double at(double time_s) const;
    double rate_at(double time_s) const;

  private:
    double amplitude_ = 0.0;
    std::array<double, 3> frequency_rad_s_{};
    std::array<double, 3> phase_rad_{};
};

}  // namespace atropos::robot
