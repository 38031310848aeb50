#pragma once

#include <string>
#include <vector>

#include "robot/layout_defaults.hpp"

namespace atropos::robot {

/// Whether an arm gets where a scene needs it.
struct ReachNeed {
    std::string what;  ///< "holds its end", "parks", "cuts the middle"
    bool reachable = false;
    std::string reason;             ///< when not
    double insertion_left_m = 0.0;  ///< to the nearer insertion limit
    double wrist_left_rad = 0.0;    ///< to the nearest wrist limit
};

struct ArmReach {
    std::string name;
    std::string tool;
    Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
    double target_distance_m = 0.0;  ///< from the remote centre to W's origin
    double reach_m = 0.0;            ///< greatest distance of the tip from the remote centre, wrist straight
    std::vector<ReachNeed> needs;
};

/// Base poses and reach for `atropos info`. PSM1 and PSM2 hold, PSM3 (when there is one) cuts or
/// grasps a middle that hangs anywhere from straight between the grips to all of the spare length below them.
std::vector<ArmReach> reach_report(const Layout& layout, const LayoutDefaults& defaults);

/// One line per arm and need.
std::string to_text(const std::vector<ArmReach>& report);

}  // namespace atropos::robot
