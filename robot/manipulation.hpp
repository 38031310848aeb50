#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>

#include "robot/smooth_random.hpp"
#include "robot/tremor.hpp"

namespace atropos::robot {

/// How two arms move a thread about. Own choices.
struct ManipulationOptions {
    double speed_m_s = 0.015;  ///< mean speed of the point between the grips, and so of the thread's middle
    double speed_window_s = 10.0;  ///< from the start, over which the mean is taken
    double amplitude_m = 0.010;    ///< bound on its way along the picture's rows; 0.6 of it down and in depth
    double time_scale = 1.0;       ///< > 1: the same motion, truly that much faster
    double thread_length_m = 0.070;
    double span_min = 0.62;  ///< least and greatest distance of the grips as shares of the thread's length:
    double span_max = 0.82;  ///< never taut, never a heap
    double opposed_m = 0.0025;  ///< bound on each arm's own motion in each axis against the other's
    double tilt_rad = 0.12;     ///< bound on each grip's rotation about each axis
    double tremor_rms_m = 0.0;  ///< see Tremor
    double ramp_s = 1.0;        ///< the motion grows from rest over this time
};

/// Smooth random manipulation of the thread between two grips, in the camera frame C. Bounds on distance and
/// reach hold at every time, because the motion is a sum of bounded parts.
class Manipulation {
  public:
    /// Start poses of the grips in C. Throws std::invalid_argument when their distance is outside the span,
    /// or a figure is negative.
    Manipulation(const std::array<Eigen::Isometry3d, 2>& X_CG, const ManipulationOptions& options,
                 std::uint64_t seed);

    /// Grip poses in C at `time_s` >= 0; at 0 the start poses, at rest.
    std::array<Eigen::Isometry3d, 2> at(double time_s) const;

  private:
    using Random3 = std::array<SmoothRandom, 3>;
    double rate_for_speed() const;
    static Eigen::Vector3d value(const Random3& random, double time_s);

    std::array<Eigen::Isometry3d, 2> X_CG_;
    ManipulationOptions options_;
    Eigen::Vector3d along_;  // unit, from grip 1 to grip 2
    Random3 common_;
    SmoothRandom stretch_;  // of half the distance
    std::array<SmoothRandom, 2> opposed_;
    Eigen::Matrix<double, 3, 2> across_;
    std::array<Random3, 2> tilt_;
    Tremor tremor_;
    double rate_ = 1.0;
};

}  // namespace atropos::robot
