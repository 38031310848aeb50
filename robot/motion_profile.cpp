#include "robot/motion_profile.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace atropos::robot {
namespace {

MotionState advanced(const MotionState& s, double t, double jerk) {
    return {s.position + t * (s.velocity + t * (0.5 * s.acceleration + t * jerk / 6.0)),
            s.velocity + t * (s.acceleration + 0.5 * t * jerk), s.acceleration + t * jerk};
}

// Time-optimal change from (v, a) to (v1, 0): ramp the acceleration to a peak, hold it, ramp it to zero.
struct VelocityChange {
    double ramp_up_s, hold_s, ramp_down_s, jerk_up, jerk_down;

    VelocityChange(double v, double a, double v1, const MotionLimits& limits) {
        const double J = limits.jerk;
        const double coasting = v + 0.5 * a * std::abs(a) / J;  // velocity if the acceleration ran out now
        const double sign = v1 >= coasting ? 1.0 : -1.0;
        const double free_peak = std::sqrt(std::max(0.0, 0.5 * a * a + sign * J * (v1 - v)));
        const double peak = sign * std::min(free_peak, limits.acceleration);
        ramp_up_s = std::abs(peak - a) / J;
        jerk_up = peak >= a ? J : -J;
        ramp_down_s = std::abs(peak) / J;
        jerk_down = peak >= 0.0 ? -J : J;
        const double ramped = 0.5 * (a + peak) * ramp_up_s + 0.5 * peak * ramp_down_s;
        hold_s = free_peak > limits.acceleration ? std::max(0.0, (v1 - v - ramped) / peak) : 0.0;
    }

    MotionState end(MotionState s) const {
        s = advanced(s, ramp_up_s, jerk_up);
        s = advanced(s, hold_s, 0.0);
        return advanced(s, ramp_down_s, jerk_down);
    }
};

// Distance covered when going to `cruise` and at once on to rest.
double distance_through(const MotionState& start, double cruise, const MotionLimits& limits) {
    MotionState s = VelocityChange(start.velocity, start.acceleration, cruise, limits)
                        .end({0.0, start.velocity, start.acceleration});
    return VelocityChange(cruise, 0.0, 0.0, limits).end({s.position, cruise, 0.0}).position;
}

// Root of distance_through = distance between velocities whose distances bracket it (Illinois' rule).
double find_cruise(const MotionState& start, double distance, double low, double high,
                   const MotionLimits& limits) {
    double f_low = distance_through(start, low, limits) - distance;
    double f_high = distance_through(start, high, limits) - distance;
    int side = 0;
    for (int i = 0; i < 100 && high - low > 1e-15 * limits.velocity; ++i) {
        const double middle = f_high > f_low
                                  ? std::clamp((low * f_high - high * f_low) / (f_high - f_low), low, high)
                                  : 0.5 * (low + high);
        const double f = distance_through(start, middle, limits) - distance;
        if (std::abs(f) < 1e-14) return middle;
        if (f > 0.0) {
            high = middle;
            f_high = f;
            if (side == 1) f_low *= 0.5;
            side = 1;
        } else {
            low = middle;
            f_low = f;
            if (side == -1) f_high *= 0.5;
            side = -1;
        }
    }
    return 0.5 * (low + high);
}

}  // namespace

void MotionProfile::append(double duration_s, double jerk) {
    assert(count_ < static_cast<int>(phases_.size()));
    phases_[static_cast<size_t>(count_++)] = {duration_s, jerk};
    duration_s_ += duration_s;
}

void MotionProfile::append_velocity_change(const MotionState& start, double velocity,
                                           const MotionLimits& limits) {
    const VelocityChange change(start.velocity, start.acceleration, velocity, limits);
    append(change.ramp_up_s, change.jerk_up);
    append(change.hold_s, 0.0);
    append(change.ramp_down_s, change.jerk_down);
}

MotionProfile MotionProfile::to_velocity(const MotionState& start, double velocity,
                                         const MotionLimits& limits) {
    MotionProfile profile;
    profile.start_ = start;
    profile.append_velocity_change(start, velocity, limits);
    return profile;
}

// The motion is a change to some cruising velocity, a stretch at it, and a change to rest. Without the
// stretch the distance grows with the cruising velocity, on each side of the velocities between rest and the
// present one; only when even the fastest cruise is too short does the stretch fill in.
MotionProfile MotionProfile::to_rest_at(const MotionState& start, double position, const MotionLimits& limits,
                                        double velocity_min, double velocity_max) {
    const double distance = position - start.position;
    const double coasting =
        std::clamp(start.velocity + 0.5 * start.acceleration * std::abs(start.acceleration) / limits.jerk,
                   velocity_min, velocity_max);
    const double near = std::min(0.0, coasting), far = std::max(0.0, coasting);
    double cruise, cruise_s = 0.0;
    if (const double most = distance_through(start, velocity_max, limits); distance >= most) {
        cruise = velocity_max;
        cruise_s = cruise > 0.0 ? (distance - most) / cruise : 0.0;
    } else if (const double least = distance_through(start, velocity_min, limits); distance <= least) {
        cruise = velocity_min;
        cruise_s = cruise < 0.0 ? (distance - least) / cruise : 0.0;
    } else if (distance >= distance_through(start, far, limits)) {
        cruise = find_cruise(start, distance, far, velocity_max, limits);
    } else if (distance <= distance_through(start, near, limits)) {
        cruise = find_cruise(start, distance, velocity_min, near, limits);
    } else {
        cruise = find_cruise(start, distance, near, far, limits);
    }
    MotionProfile profile;
    profile.start_ = start;
    profile.append_velocity_change(start, cruise, limits);
    profile.append(cruise_s, 0.0);
    profile.append_velocity_change({0.0, cruise, 0.0}, 0.0, limits);
    return profile;
}

MotionState MotionProfile::at(double time_s) const {
    MotionState s = start_;
    for (int i = 0; i < count_; ++i) {
        const Phase& phase = phases_[static_cast<size_t>(i)];
        if (time_s <= phase.duration_s) return advanced(s, time_s, phase.jerk);
        s = advanced(s, phase.duration_s, phase.jerk);
        time_s -= phase.duration_s;
    }
    return {s.position + time_s * s.velocity, s.velocity, 0.0};
}

MotionProfile::Extent MotionProfile::extent() const {
    MotionState s = start_;
    Extent extent{s.position, s.position};
    const auto cover = [&](double p) {
        extent.lowest = std::min(extent.lowest, p);
        extent.highest = std::max(extent.highest, p);
    };
    for (int i = 0; i < count_; ++i) {
        const Phase& phase = phases_[static_cast<size_t>(i)];
        // Turning points: v + a t + j t^2 / 2 = 0.
        const double d = s.acceleration * s.acceleration - 2.0 * phase.jerk * s.velocity;
        if (d >= 0.0) {
            const double q = -(s.acceleration + std::copysign(std::sqrt(d), s.acceleration));
            for (const double t :
                 {phase.jerk != 0.0 ? q / phase.jerk : -1.0, q != 0.0 ? 2.0 * s.velocity / q : -1.0})
                if (t > 0.0 && t < phase.duration_s) cover(advanced(s, t, phase.jerk).position);
        }
        s = advanced(s, phase.duration_s, phase.jerk);
        cover(s.position);
    }
    return extent;
}

}  // namespace atropos::robot
