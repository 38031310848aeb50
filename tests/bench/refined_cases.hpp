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
    int frames_to_return = 0;  ///< after the occluder has gone
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
};

std::vector<RefinedCase> refined_cases();

/// A drawn frame as the tracker of that case gets it.
tracker::StereoFrame measured_frame(const RefinedCase& c, const support::SyntheticFrame& drawn, int index);

}  // namespace atropos::bench
