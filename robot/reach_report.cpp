#include "robot/reach_report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace atropos::robot {
namespace {

ReachNeed need(const std::string& what, const Psm& psm, const ArmPlacement& arm,
               const Eigen::Isometry3d& X_WF, const Eigen::Isometry3d& X_TF) {
    ReachNeed n;
    n.what = what;
    const auto solution = joints_for(psm, arm.X_WB, X_WF, X_TF);
    n.reachable = static_cast<bool>(solution);
    n.reason = reason(solution);
    const Joints below = solution.q - psm.limits().lower, above = psm.limits().upper - solution.q;
    const Joints left = below.cwiseMin(above);
    n.insertion_left_m = left[2];
    n.wrist_left_rad = left.tail<2>().minCoeff();
    return n;
}

}  // namespace

std::vector<ArmReach> reach_report(const Layout& layout, const LayoutDefaults& defaults) {
    const auto X_WG = defaults.X_WG();
    std::vector<ArmReach> report;
    for (size_t i = 0; i < layout.arms.size(); ++i) {
        const ArmPlacement& arm = layout.arms[i];
        const Psm psm(tool(arm.tool));
        ArmReach r;
        r.name = arm.name;
        r.tool = arm.tool;
        r.X_WB = arm.X_WB;
        r.target_distance_m = arm.X_WB.translation().norm();
        Joints deepest = Joints::Zero();
        deepest[2] = psm.limits().upper[2];
        r.reach_m = psm.forward(deepest).translation().norm();
        if (i < 2) {
            r.needs.push_back(need("holds its end", psm, arm, X_WG[i], psm.tool().X_TG));
        } else {
            const bool cuts = psm.tool().X_TS.has_value();
            const Eigen::Isometry3d& X_TF = cuts ? *psm.tool().X_TS : psm.tool().X_TG;
            const Eigen::Vector3d p_WB = arm.X_WB.translation(), x = Eigen::Vector3d::UnitX();
            const double half = 0.5 * defaults.thread_length_m, across = 0.5 * defaults.grip_distance_m;
            const double hang =
                std::sqrt(std::max(0.0, half * half - across * across));  // of a V, the deepest
            const Eigen::Vector3d highest(0.0, 0.0, defaults.grip_height_m),
                lowest(0.0, 0.0, defaults.grip_height_m - hang);
            const std::string does = cuts ? "cuts" : "grasps";
            r.needs.push_back(need("parks", psm, arm, defaults.X_WS_parked(p_WB), X_TF));
            r.needs.push_back(
                need(does + " a taut middle", psm, arm, LayoutDefaults::X_WS(highest, x, p_WB), X_TF));
            r.needs.push_back(
                need(does + " a slack middle", psm, arm, LayoutDefaults::X_WS(lowest, x, p_WB), X_TF));
        }
        report.push_back(std::move(r));
    }
    return report;
}

std::string to_text(const std::vector<ArmReach>& report) {
    std::string text;
    char line[256];
    for (const ArmReach& r : report) {
        const Eigen::Vector3d p = 1e3 * r.X_WB.translation(), z = r.X_WB.linear().col(2);
        std::snprintf(
            line, sizeof line,
            "%s %s: remote centre (%.1f, %.1f, %.1f) mm, aims along (%.3f, %.3f, %.3f), target at %.1f mm, "
            "reaches %.1f mm\n",
            r.name.c_str(), r.tool.c_str(), p.x(), p.y(), p.z(), -z.x(), -z.y(), -z.z(),
            1e3 * r.target_distance_m, 1e3 * r.reach_m);
        text += line;
        for (const ReachNeed& n : r.needs) {
            if (n.reachable)
                std::snprintf(line, sizeof line,
                              "  %s: yes, %.1f mm of insertion and %.0f deg of wrist left\n", n.what.c_str(),
                              1e3 * n.insertion_left_m, n.wrist_left_rad * 57.29577951308232);
            else
                std::snprintf(line, sizeof line, "  %s: no, %s\n", n.what.c_str(), n.reason.c_str());
            text += line;
        }
    }
    return text;
}

}  // namespace atropos::robot
