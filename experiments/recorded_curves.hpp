#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace atropos::experiments {

/// The control points of one frame of a track.
struct RecordedCurve {
    int frame = 0;
    double time_s = 0.0;
    Eigen::Matrix3Xd Q;  ///< 3 x K, in C, m
};

/// Folders of tracks in and below `folder`, in order of their names. Throws scenes::FileError when there is
/// none.
std::vector<std::filesystem::path> track_folders(const std::filesystem::path& folder);

/// The frames of a track whose thread was seen, all of one K. Throws scenes::FileError.
std::vector<RecordedCurve> read_recorded_curves(const std::filesystem::path& track);

}  // namespace atropos::experiments
