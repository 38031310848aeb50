#pragma once

#include <memory>

#include "tracker/stereo_tracker.hpp"

namespace atropos::experiments {

/// The tracker that `config` describes, with the file it names read. Throws scenes::FileError when that can't
/// be used, std::invalid_argument as tracker::make_tracker does.
std::unique_ptr<tracker::StereoTracker> make_configured_tracker(const scenes::TrackerConfig& config,
                                                                const scenes::StereoRig& rig);

}  // namespace atropos::experiments
