#pragma once

#include <Eigen/Core>
#include <string>

namespace atropos::sim {

enum class EventKind { kGrasp, kSlip, kRelease, kCut, kCollision, kContactForce };

/// "grasp", "slip", "release", "cut", "collision", "contact_force": as in truth/events.csv.
std::string to_string(EventKind kind);

struct Event {
    double time_s = 0.0;
    EventKind kind = EventKind::kGrasp;
    int instrument = -1;  ///< -1: none
    std::string name;     ///< of the instrument
    std::string other;    ///< of what it collided with: an instrument's name or "tissue"
    double s_m = -1.0;    ///< material arc length; -1: not on the thread
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
    double force_N = 0.0;  ///< slip and contact force
};

}  // namespace atropos::sim
