#include "robot/scissors_status.hpp"

#include <cmath>

namespace atropos::robot {

const char* to_string(ScissorsState state) {
    switch (state) {
        case ScissorsState::kPark:
            return "park";
        case ScissorsState::kApproach:
            return "approach";
        case ScissorsState::kAlign:
            return "align";
        case ScissorsState::kFollow:
            return "follow";
        case ScissorsState::kClose:
            return "close";
        case ScissorsState::kVerify:
            return "verify";
        case ScissorsState::kRetract:
            return "retract";
        case ScissorsState::kAbort:
            return "abort";
        case ScissorsState::kDone:
            return "done";
    }
    return "?";
}

double ErrorBudget::total_m() const {
    return std::sqrt(tracking_m * tracking_m + registration_m * registration_m + prediction_m * prediction_m +
                     mechanics_m * mechanics_m);
}

}  // namespace atropos::robot
