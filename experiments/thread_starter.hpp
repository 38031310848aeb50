#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "tracker/stereo_tracker.hpp"
#include "tracker/thread_finder.hpp"

namespace atropos::experiments {

/// Where no end is measured, the finder looks at every frame: a tracker that has no curve gets the one it
/// sees, in the first frame and again whenever the thread is lost or long out of sight, and one that has gets
/// its ends. Never what the finder doubts.
class ThreadStarter {
  public:
    /// `seed_px`: near which point of the left image the thread runs when it is first looked for.
    ThreadStarter(const scenes::TrackerConfig& config, const scenes::StereoRig& rig,
                  const std::optional<Eigen::Vector2d>& seed_px = std::nullopt);

    /// Tracks a frame, by a new start where it is wanted.
    const tracker::TrackResult& track(tracker::StereoTracker& tracker, const tracker::StereoFrame& frame);

  private:
    tracker::StereoFrame with_ends(const tracker::StereoFrame& frame, const tracker::FoundThread& found);
    tracker::NurbsCurve fitting(const tracker::NurbsCurve& curve) const;

    scenes::TrackerConfig config_;
    tracker::ThreadFinder finder_;
    std::optional<Eigen::Vector2d> seed_px_;
    int unseen_frames_ = 0;
    std::optional<std::array<Eigen::Vector3d, 2>> ends_C_;  ///< as last seen
};

}  // namespace atropos::experiments
