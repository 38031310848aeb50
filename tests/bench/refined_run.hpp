#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scenes/tracker_config.hpp"
#include "tests/bench/refined_cases.hpp"
#include "tests/bench/tracking_tally.hpp"
#include "tracker/curve_refinement.hpp"

namespace atropos::bench {

/// One tracker of a comparison.
struct Contender {
    std::string name;
    scenes::TrackerConfig config;
    tracker::CurvePriors priors = {};  ///< of the refined ones
    std::optional<tracker::DeformationPrior> deformation = {};
};

/// The refined tracker as it is by default.
Contender refined_contender();

struct SeedRange {
    std::uint64_t first = 1, last = 5;
};

/// A frame that was just tracked.
struct TrackedFrameView {
    const RefinedCase& row;  ///< with the seed of the sequence
    int index;
    const support::SyntheticFrame& drawn;
    const tracker::TrackResult& result;
    double error_mm, error_px, middle_mm;
};

struct RunOptions {
    int frames = 100;  ///< of each sequence
    SeedRange seeds;
    std::function<void(const TrackedFrameView&)> look = {};  ///< of the first contender
};

/// What is measured of a row beside its trackers.
struct RowRun {
    std::vector<TrackingTally> tallies;  ///< of each contender
    Values bound_mm;                     ///< Bayesian Cramer-Rao, of every tenth frame
    double largest_motion_px = 0.0;      ///< of the knots, from one frame to the next
    Values late_error_mm;                ///< of the first contender after 30 frames
    Values length_percent;               ///< of the first contender after 30 frames, off
    Values row_share, roll_share;        ///< likewise, of what the right eye is off by: off, share of it
    int frames_to_return = 0;            ///< of the first contender, after an occlusion, at most
};

RowRun run_row(const RefinedCase& c, const std::vector<Contender>& contenders, const RunOptions& options);

}  // namespace atropos::bench
