#pragma once

#include "robot/motion_profile.hpp"

namespace atropos::robot {

/// Set-point of one joint that follows a streamed target without ever exceeding velocity, acceleration, jerk
/// or position limits. A target that itself keeps well inside them is followed without lag.
class JointServo {
  public:
    JointServo() = default;
    JointServo(const MotionLimits& limits, double lower, double upper, double position)
        : limits_(limits), lower_(lower), upper_(upper), state_{position, 0.0, 0.0} {}

    /// One step of `dt_s` towards a target of which position, velocity and acceleration at the end of the
    /// step are given; a target that jumps has neither velocity nor acceleration.
    void follow(const MotionState& target, double dt_s);

    /// One step of the fastest stop.
    void brake(double dt_s);

    const MotionState& state() const { return state_; }
    const MotionLimits& limits() const { return limits_; }
    bool at_rest() const { return state_.velocity == 0.0 && state_.acceleration == 0.0; }

    /// A faster joint stops first, then obeys.
    void limit_velocity(double velocity) { limits_.velocity = velocity; }

    /// Where the fastest stop would end.
    double stopping_position() const;

    /// For motions planned elsewhere within the same limits.
    void set_state(const MotionState& state) { state_ = state; }

  private:
    bool admissible(const MotionState& state) const;

    MotionLimits limits_;
    double lower_ = -1.0;
    double upper_ = 1.0;
    MotionState state_;
};

}  // namespace atropos::robot
