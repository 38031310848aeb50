#pragma once

#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "scenes/polyline.hpp"
#include "scenes/stereo_rig.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::experiments {

/// A folder of stereo pictures with a calibration (design: "Sequence"). Only calib/stereo.yaml, left/ and
/// right/ must be there; everything that is there is checked when it is opened. Never reads truth/.
class Sequence {
  public:
    /// Throws scenes::FileError: a missing eye, counts or sizes that differ, no frames, bad CSV, ends that
    /// are not finite or not before the camera.
    static Sequence open(const std::filesystem::path& folder);

    const std::filesystem::path& folder() const { return folder_; }
    const scenes::StereoRig& rig() const { return rig_; }
    int frames() const { return static_cast<int>(left_.size()); }
    double time_s(int frame) const { return time_s_[static_cast<size_t>(frame)]; }

    /// Pictures, time and measured ends of a frame. Throws scenes::FileError when a picture can't be read.
    tracker::StereoFrame frame(int index) const;

  private:
    void read_times();
    void read_tips();

    std::filesystem::path folder_;
    scenes::StereoRig rig_;
    std::vector<std::filesystem::path> left_, right_;
    std::vector<double> time_s_;
    std::vector<std::array<std::optional<tracker::MeasuredTip>, 2>> tips_;
};

/// The true thread of a sequence, for metrics only: the judged span of each frame in C (m), and whether each
/// of its points is visible in the left and in the right eye.
struct TruthFrame {
    scenes::Polyline span_C;
    std::vector<std::array<bool, 2>> visible;
};

/// Reads truth/thread.csv. Throws scenes::FileError.
std::vector<TruthFrame> read_truth(const std::filesystem::path& sequence, int frames);

}  // namespace atropos::experiments
