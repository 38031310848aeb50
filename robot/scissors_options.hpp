#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>

#include "robot/tool.hpp"

namespace atropos::robot {

/// Where on the span the thread is to be cut. The first that is set counts.
struct CutPlace {
    std::optional<double> from_end0_m;  ///< arc length from end 0
    std::optional<double> from_end1_m;  ///< arc length from end 1
    double fraction = 0.5;              ///< of the span's arc length, from end 0
};

/// What the scissors are asked to do and how careful they are. Own choices, measured in
/// tests/robot/scissors_command_test.
struct ScissorsOptions {
    CutPlace place;
    double tolerance_m = 0.002;  ///< along the thread
    int max_attempts = 3;
    double sigmas = 2.0;  ///< how many the gate leaves room for

    double registration_sigma_m = 0.0019;  ///< RMS of the blade point in C before images help (calibrated)
    /// Farthest an estimate's end may lie from the measured grip that holds it.
    double max_end_gap_m = 0.010;
    double max_length_change = 0.08;  ///< of the span, as a share
    double max_jump_m = 0.005;        ///< of the target between prediction and estimate
    double min_confidence = 0.5;      ///< of an estimate
    double max_estimate_age_s = 0.5;  ///< capture to now; older: the gate is closed
    double lost_timeout_s = 1.5;      ///< without a usable estimate: abort
    double timeout_s = 30.0;          ///< from command to close
    double verify_timeout_s = 1.5;

    double standoff_m = 0.015;          ///< of the blade point before the thread
    double clearance_m = 0.005;         ///< between arms, always
    double clearance_margin_m = 0.003;  ///< on top of it, for what is only measured
    double approach_speed_m_s = 0.040;
    double near_speed_m_s = 0.020;  ///< relative to the thread, within the stand-off
    double turn_speed_rad_s = 1.5;
    double open_jaw_rad = 0.70;     ///< at most the tool's widest
    double closed_jaw_rad = -0.10;  ///< squeezing; at least the tool's least
    double hold_s = 0.10;           ///< shut
    double dwell_s = 0.05;          ///< the gate must have been open this long
    double arm_lag_s = 0.0;         ///< of the joints behind their set-points, made up for by prediction

    Eigen::Vector3d p_CR = Eigen::Vector3d(0.005, 0.0, 0.0);  ///< right eye, must see past the instrument too
    /// Grip points of the holding arms in their tip frames.
    std::array<Eigen::Isometry3d, 2> X_TG = {tool("LARGE_NEEDLE_DRIVER").X_TG,
                                             tool("LARGE_NEEDLE_DRIVER").X_TG};

    /// Throws std::invalid_argument when something that must be above 0 is not, or the place is off the span.
    void check() const;
};

}  // namespace atropos::robot
