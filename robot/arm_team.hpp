#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "robot/arm_clearance.hpp"
#include "robot/robot_arm.hpp"

namespace atropos::robot {

/// Clearances the arms keep among each other and from the endoscope, as they believe to stand. 5 mm is the
/// design's, the others own choice.
struct TeamLimits {
    double planned_m = 0.005;  ///< a planned move that would come nearer is refused
    double slow_m = 0.003;     ///< nearer, arms may only part, or creep on: a period may take at most a
    double floor_m = 0.002;    ///< fiftieth of what is left above the floor
};

/// All arms of a scene, stepped together. Knows only what is measured or commanded.
class ArmTeam {
  public:
    /// `endoscope_C`: the endoscope's capsule in C.
    ArmTeam(std::vector<RobotArm> arms, const scenes::Capsule& endoscope_C, const TeamLimits& limits = {});

    std::vector<RobotArm>& arms() { return arms_; }
    const std::vector<RobotArm>& arms() const { return arms_; }
    /// Throws std::invalid_argument that lists the known names.
    RobotArm& arm(std::string_view name);

    /// Whether an arm may go from its goal to `q`, straight in joint space, while the others stand at theirs:
    /// the capsules swept on the way keep `planned_m`.
    CommandResult check_move(std::string_view arm, const Joints& q) const;

    /// PsmArm::move_jp after check_move.
    CommandResult move_jp(std::string_view arm, const Joints& q, double speed_ratio = 1.0);

    /// One period of all arms. Where two would come too near before they could stop, those that move are
    /// held, and `warning` says which.
    void step();

    const std::string& warning() const { return warning_; }
    std::int64_t stops() const { return stops_; }

    /// Least clearance of any two arms, or of an arm and the endoscope, at the present set-points.
    double clearance_m() const;

  private:
    size_t index(std::string_view name) const;
    Capsules capsules_C(size_t arm, const Joints& q, double jaw_rad) const;
    std::vector<double> stopping_clearances_m() const;
    void keep_apart(const std::vector<PsmArm>& before, const std::vector<double>& apart_before);

    std::vector<RobotArm> arms_;
    Capsules endoscope_C_;
    TeamLimits limits_;
    std::vector<double> apart_m_;  // of each pair, if all stopped now; first each arm's with the endoscope
    std::string warning_;
    std::int64_t stops_ = 0;
};

}  // namespace atropos::robot
