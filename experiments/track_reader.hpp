#pragma once

#include <filesystem>
#include <vector>

#include "scenes/thread_estimate.hpp"

namespace atropos::experiments {

struct TrackedFrame {
    int frame = 0;
    scenes::ThreadEstimate estimate;
};

/// Reads a track folder, or a bare track.csv: any number of samples a frame, sigmas optional. In a bare file
/// the frames between the first and the last that have no rows are lost. Throws scenes::FileError.
std::vector<TrackedFrame> read_track(const std::filesystem::path& track);

}  // namespace atropos::experiments
