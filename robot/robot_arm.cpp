#include "robot/robot_arm.hpp"

#include <algorithm>
#include <cmath>

namespace atropos::robot {

RobotArm::RobotArm(const ArmPlacement& placement, const FrameTree& tree, const Joints& q, double jaw_rad,
                   const Imperfection& imperfection, std::uint64_t seed, const ArmLimits& limits)
    : name_(placement.name),
      true_X_WB_(tree.pose("W", placement.name + "_base")),
      true_X_CB_(tree.pose("C", placement.name + "_base")),
      X_CB_(registered(true_X_CB_, tree.pose("C", "W").translation(), imperfection, seed, placement.name)),
      imperfection_(imperfection),
      controller_(Psm(tool(placement.tool)), q, jaw_rad, limits),
      drive_(imperfection, seed, placement.name, controller_.setpoint()),
      delays_(seed, "arm." + placement.name + ".delays"),
      steps_per_message_(
          std::max<std::int64_t>(1, std::llround(imperfection.publish_period_s / PsmArm::kPeriod_s))) {
    publish();
    measured_ = under_way_.front().state;
    under_way_.clear();
}

void RobotArm::publish() {
    const Joints q = drive_.read().value;
    const double now = time_s();
    const double arrival = now + imperfection_.latency_s + imperfection_.jitter_s * delays_.uniform();
    under_way_.push_back({arrival, {{now, q, drive_.jaw_rad(), X_CB_ * psm().forward(q)}}});
}

void RobotArm::step_drives() {
    drive_.step(controller_.setpoint());
    if (controller_.steps() % steps_per_message_ == 0) publish();
    // Messages keep their order, as on a topic. Half a nanosecond forgives the rounding of times.
    while (!under_way_.empty() && under_way_.front().arrival_s <= time_s() + 5e-10) {
        measured_ = under_way_.front().state;
        under_way_.pop_front();
    }
}

Measured<Joints> RobotArm::steady_state_error() const {
    return {controller_.goal() - drive_.encoders()};
}

True<ArmState> RobotArm::truth() const {
    const Joints q = drive_.true_joints().value;
    return {{time_s(), q, drive_.jaw_rad(), true_X_CB_ * psm().forward(q)}};
}

True<std::array<Eigen::Isometry3d, kLinkCount>> RobotArm::true_links_W() const {
    auto X = psm().link_poses(drive_.true_joints().value, drive_.jaw_rad());
    for (Eigen::Isometry3d& link : X) link = true_X_WB_ * link;
    return {X};
}

True<std::vector<scenes::Capsule>> RobotArm::true_capsules_W() const {
    auto capsules = psm().capsules(drive_.true_joints().value, drive_.jaw_rad());
    for (scenes::Capsule& c : capsules) c = {true_X_WB_ * c.a, true_X_WB_ * c.b, c.radius_m};
    return {capsules};
}

Measured<std::vector<scenes::Capsule>> RobotArm::measured_capsules_C() const {
    const ArmState& s = measured_.value;
    auto capsules = psm().capsules(s.q, s.jaw_rad);
    for (scenes::Capsule& c : capsules) c = {X_CB_ * c.a, X_CB_ * c.b, c.radius_m};
    return {capsules};
}

}  // namespace atropos::robot
