#pragma once

#include <optional>

#include "tracker/stereo_tracker.hpp"
#include "tracker/thread_tracker.hpp"

namespace atropos::tracker {

/// Finds a curve again by discrete search, where continuous refinement has no gradient to follow: the paper's
/// E2 (eq. 15-18) with exact dynamic programming and labels along the viewing rays, longer in depth. Coarse:
/// what it returns is to be refined.
class Recovery {
  public:
    Recovery(scenes::TrackerConfig config, const scenes::StereoRig& rig);

    /// In the neighbourhood of a curve; `length_m` is the thread's.
    std::optional<NurbsCurve> near(const StereoFrame& frame, const NurbsCurve& curve);

    /// Anywhere between two measured ends (III); nothing when an end is unknown or no thread is seen.
    std::optional<NurbsCurve> between_tips(const StereoFrame& frame);

  private:
    std::optional<NurbsCurve> curve_of(const TrackResult& result) const;

    int degree_;
    int control_points_;
    ThreadTracker search_;
};

}  // namespace atropos::tracker
