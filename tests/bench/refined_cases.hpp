#pragma once

#include <string>
#include <vector>

#include "tests/support/synthetic_sequence.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::bench {

/// What a row is held to; 0 = nothing.
struct RowBounds {
    double mean_mm = 0.0, aim_mm = 0.0;
    double mean_px = 0.0, aim_px = 0.0;
    double lost_percent = 0.0;
    double symmetric_mm = 0.0;
    double length_percent = 0.0;  ///< of error, after 30 frames
    int frames_to_return = 0;     ///< after the occluder has gone
};

/// A row of the refined tracker's table: what is drawn, and what the tracker is told wrongly.
struct RefinedCase {
    std::string name;
    std::string words;
    support::SyntheticSequenceOptions options;
    RowBounds bounds;
    int control_points = 16;
    double mask_error_m = 0.0;  ///< of the instruments' measured poses, constant over the sequence
    bool from_tips = false;     ///< begins between the measured ends, as the closed loop does
    double row_offset_px =
        0.0;                    ///< of the right eye's rows, that the calibration does not know; sign by seed
    double roll_rad = 0.0;      ///< of the right eye about its axis, likewise
    double row_sigma_px = 0.0;  ///< that the tracker is told of its calibration; 0: exact
    double told_length = 1.0;   ///< share of the true length that the tracker is told; 0 = nothing
};

/// What the right eye is off by against the rig as the tracker is told it.
tracker::EyeCorrection calibration_error(const RefinedCase& c);

/// The rig as the tracker is told it.
scenes::StereoRig told_rig(const RefinedCase& c);

std::vector<RefinedCase> refined_cases();

/// A drawn frame as the tracker of that case gets it.
tracker::StereoFrame measured_frame(const RefinedCase& c, const support::SyntheticFrame& drawn, int index);

}  // namespace atropos::bench
