#pragma once

#include <filesystem>

#include "experiments/sequence.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::experiments {

/// Tracks `frame`, number `frame.index` of the sequence, again from the state before it and writes what
/// happens inside: input, ridge, mask and cost pictures of both eyes, the curve after each step, label and
/// energy per node, the truth where there is one.
void explain_frame(tracker::StereoTracker& tracker, const tracker::TrackerState& before,
                   const Sequence& sequence, const tracker::StereoFrame& frame,
                   const std::filesystem::path& folder);

}  // namespace atropos::experiments
