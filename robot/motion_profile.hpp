#pragma once

#include <array>

namespace atropos::robot {

/// Bounds on one coordinate; SI (rad or m).
struct MotionLimits {
    double velocity = 1.0;
    double acceleration = 1.0;
    double jerk = 1.0;
};

struct MotionState {
    double position = 0.0;
    double velocity = 0.0;
    double acceleration = 0.0;
};

/// A motion of one coordinate in at most seven phases of constant jerk, within the limits at every instant.
class MotionProfile {
  public:
    MotionProfile() = default;

    /// To the velocity `velocity`, without acceleration at the end, in the shortest time.
    static MotionProfile to_velocity(const MotionState& start, double velocity, const MotionLimits& limits);

    /// To rest at `position`. Velocities stay in [velocity_min, velocity_max], which must contain 0.
    static MotionProfile to_rest_at(const MotionState& start, double position, const MotionLimits& limits,
                                    double velocity_min, double velocity_max);
    static MotionProfile to_rest_at(const MotionState& start, double position, const MotionLimits& limits) {
        return to_rest_at(start, position, limits, -limits.velocity, limits.velocity);
    }

    double duration_s() const { return duration_s_; }

    /// State at `time_s` >= 0; after the end, the last velocity goes on.
    MotionState at(double time_s) const;

    /// Least and greatest position on the way.
    struct Extent {
        double lowest;
        double highest;
    };
    Extent extent() const;

  private:
    struct Phase {
        double duration_s;
        double jerk;
    };
    void append(double duration_s, double jerk);
    void append_velocity_change(const MotionState& start, double velocity, const MotionLimits& limits);

    MotionState start_;
    std::array<Phase, 7> phases_{};
    int count_ = 0;
    double duration_s_ = 0.0;
};

}  // namespace atropos::robot
