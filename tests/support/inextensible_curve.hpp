#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "scenes/polyline.hpp"

namespace atropos::support {

/// How an inextensible curve lies and moves. Angles in rad; defaults: a 70 mm thread seen as an arc.
struct InextensibleCurveOptions {
    std::uint64_t seed = 1;
    double length_m = 0.070;
    Eigen::Vector3d centre_C = {0.0, 0.0, 0.100};
    double heading_rad = 0.7;    ///< of the chord in the image plane, from x
    double turning_rad = 2.0;    ///< total turn of the resting arc
    double turning_share = 1.0;  ///< of the length, about the middle, in which it turns: a loop when small
    double turning_swing_rad = 0.0;      ///< by which the total turn is more and less in turns, first less
    double travel_share = 0.0;           ///< of the length, by which the turn's middle goes to and fro
    double swing_frames = 120.0;         ///< a swing there and back
    double depth_tilt_rad = 0.25;        ///< resting slope against the image plane
    double arc_tilt_rad = 0.3;           ///< angle of the arc's plane out of the image plane
    double speed_m_per_frame = 0.00013;  ///< mean displacement of a point a frame
    int burst_ratio = 2;                 ///< speed in a burst over the mean; 1 = even
};

/// A thread of exactly constant length given by formulae: the unit tangent is a smooth function of arc length
/// and time, and the curve its integral. Knows nothing of physics, so that a test by it shares no code with
/// the simulator.
class InextensibleCurve {
  public:
    explicit InextensibleCurve(const InextensibleCurveOptions& options);

    /// The curve at a (fractional) frame: `segments` + 1 points, each link of length L / segments, in C (m).
    scenes::Polyline at(double frame, int segments = 400) const;

  private:
    struct Wave {
        double amplitude_rad;
        double rate_rad;  ///< phase a unit of motion phase
        double offset_rad;
    };
    static constexpr int kModes = 4;

    double wave(const std::array<Wave, 3>& waves, double phase) const;
    double motion_phase(double frame) const;
    scenes::Polyline at_phase(double phase, double frame, int segments) const;

    InextensibleCurveOptions options_;
    std::array<std::array<Wave, 3>, kModes> bend_;    ///< in the plane of the arc
    std::array<std::array<Wave, 3>, kModes> lift_;    ///< out of it
    std::array<std::array<Wave, 3>, 3> translation_;  ///< of the centre, in units of 10 mm
    double phase_per_frame_ = 1.0;
};

}  // namespace atropos::support
