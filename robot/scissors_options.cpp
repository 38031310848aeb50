#include "robot/scissors_options.hpp"

#include <stdexcept>
#include <string>

namespace atropos::robot {

void ScissorsOptions::check() const {
    const auto positive = [](double value, const char* what) {
        if (!(value > 0.0))
            throw std::invalid_argument(std::string("ScissorsCommand: ") + what + ", expected above 0");
    };
    positive(tolerance_m, "tolerance_m");
    positive(max_attempts, "max_attempts");
    positive(registration_sigma_m, "registration_sigma_m");
    positive(standoff_m, "standoff_m");
    positive(approach_speed_m_s, "approach_speed_m_s");
    positive(near_speed_m_s, "near_speed_m_s");
    positive(turn_speed_rad_s, "turn_speed_rad_s");
    if (!(place.fraction >= 0.0 && place.fraction <= 1.0))
        throw std::invalid_argument("ScissorsCommand: fraction of the span, expected in [0, 1]");
}

}  // namespace atropos::robot
