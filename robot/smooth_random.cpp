#include "robot/smooth_random.hpp"

#include <cmath>
#include <numbers>

namespace atropos::robot {

SmoothRandom::SmoothRandom(scenes::RandomStream& random, double bound, double low_rad_s, double high_rad_s)
    : amplitude_(bound / 3.0) {
    for (double& f : frequency_rad_s_) f = random.uniform(low_rad_s, high_rad_s);
    for (double& p : phase_rad_) p = random.uniform(0.0, 2.0 * std::numbers::pi);
}

double SmoothRandom::at(double t) const {
    double sum = 0.0;
    for (size_t i = 0; i < 3; ++i) sum += std::sin(frequency_rad_s_[i] * t + phase_rad_[i]);
    return amplitude_ * sum;
}

double SmoothRandom::rate_at(double t) const {
    double sum = 0.0;
    for (size_t i = 0; i < 3; ++i)
        sum += frequency_rad_s_[i] * std::cos(frequency_rad_s_[i] * t + phase_rad_[i]);
    return amplitude_ * sum;
}

}  // namespace atropos::robot
