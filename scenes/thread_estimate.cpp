#include "scenes/thread_estimate.hpp"

namespace atropos::scenes {

const char* to_string(TrackStatus status) {
    switch (status) {
        case TrackStatus::kTracking:
            return "tracking";
        case TrackStatus::kCoasting:
            return "coasting";
        case TrackStatus::kLost:
            break;
    }
    return "lost";
}

}  // namespace atropos::scenes
