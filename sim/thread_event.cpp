#include "sim/thread_event.hpp"

namespace atropos::sim {

std::string to_string(EventKind kind) {
    switch (kind) {
        case EventKind::kGrasp:
            return "grasp";
        case EventKind::kSlip:
            return "slip";
        case EventKind::kRelease:
            return "release";
        case EventKind::kCut:
            return "cut";
        case EventKind::kCollision:
            return "collision";
        case EventKind::kContactForce:
            return "contact_force";
    }
    return "unknown";
}

}  // namespace atropos::sim
