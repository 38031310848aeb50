#include "robot/tremor.hpp"

#include <cmath>
#include <numbers>

namespace atropos::robot {

constexpr double kLow_rad_s = 16.0 * std::numbers::pi, kHigh_rad_s = 24.0 * std::numbers::pi;

Tremor::Tremor(double rms_m, std::uint64_t seed) {
    scenes::RandomStream random(seed, "motion.tremor");
    const double bound = rms_m * 3.0 / std::sqrt(1.5);  // a sum of three sinusoids of a third each
    for (auto& hand : hands_)
        for (SmoothRandom& axis : hand) axis = SmoothRandom(random, bound, kLow_rad_s, kHigh_rad_s);
}

Eigen::Vector3d Tremor::at(size_t hand, double time_s) const {
    const auto& axes = hands_[hand];
    return {axes[0].at(time_s), axes[1].at(time_s), axes[2].at(time_s)};
}

}  // namespace atropos::robot
