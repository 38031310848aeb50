#include "robot/joint_servo.hpp"

#include <algorithm>
#include <cmath>

namespace atropos::robot {
namespace {

// Below these a joint counts as standing (rad or m, per second): far under a nanometre in a step.
constexpr double kStandingVelocity = 1e-9, kStandingAcceleration = 1e-5;

// The next state on the way to a moving target. In the frame of a target at constant acceleration it is a
// motion to rest, with what the target leaves of the limits.
MotionState towards(const MotionState& s, const MotionState& target, const MotionLimits& limits,
                    double dt_s) {
    const double before_v = target.velocity - target.acceleration * dt_s;
    const double before_p = target.position - dt_s * (target.velocity - 0.5 * dt_s * target.acceleration);
    const MotionState relative{s.position - before_p, s.velocity - before_v,
                               s.acceleration - target.acceleration};
    MotionLimits left = limits;
    left.acceleration -= std::abs(target.acceleration);
    const double lowest = -limits.velocity - std::min(before_v, target.velocity);
    const double highest = limits.velocity - std::max(before_v, target.velocity);
    MotionState next = MotionProfile::to_rest_at(relative, 0.0, left, lowest, highest).at(dt_s);
    next.position += target.position;
    next.velocity += target.velocity;
    next.acceleration += target.acceleration;
    return next;
}

}  // namespace

// Within the limits, and still so when the fastest stop begins now.
bool JointServo::admissible(const MotionState& s) const {
    const double coasting = s.velocity + 0.5 * s.acceleration * std::abs(s.acceleration) / limits_.jerk;
    const double most = limits_.velocity * (1.0 + 1e-12);
    if (std::abs(s.velocity) > most || std::abs(coasting) > most ||
        std::abs(s.acceleration) > limits_.acceleration * (1.0 + 1e-12))
        return false;
    const auto extent = MotionProfile::to_velocity(s, 0.0, limits_).extent();
    return extent.lowest >= lower_ - 1e-10 && extent.highest <= upper_ + 1e-10;
}

double JointServo::stopping_position() const {
    const auto stop = MotionProfile::to_velocity(state_, 0.0, limits_);
    return stop.at(stop.duration_s()).position;
}

void JointServo::brake(double dt_s) {
    state_ = MotionProfile::to_velocity(state_, 0.0, limits_).at(dt_s);
    if (std::abs(state_.velocity) < kStandingVelocity &&
        std::abs(state_.acceleration) < kStandingAcceleration)
        state_.velocity = state_.acceleration = 0.0;
}

// Every state reached is admissible: where the target's own motion would end this, less of it is followed,
// and at last the joint takes the stop that the previous state kept open.
void JointServo::follow(const MotionState& target, double dt_s) {
    const double v = std::clamp(target.velocity, -0.95 * limits_.velocity, 0.95 * limits_.velocity);
    const double a = std::abs(target.acceleration) < 0.7 * limits_.acceleration ? target.acceleration : 0.0;
    MotionState next = towards(state_, {target.position, v, a}, limits_, dt_s);
    if (a != 0.0 && !admissible(next)) next = towards(state_, {target.position, v, 0.0}, limits_, dt_s);
    if (v != 0.0 && !admissible(next)) next = towards(state_, {target.position, 0.0, 0.0}, limits_, dt_s);
    if (!admissible(next)) return brake(dt_s);
    if (v == 0.0 && std::abs(next.position - target.position) < 1e-12 &&
        std::abs(next.velocity) < kStandingVelocity && std::abs(next.acceleration) < kStandingAcceleration)
        next = {target.position, 0.0, 0.0};
    state_ = next;
}

}  // namespace atropos::robot
