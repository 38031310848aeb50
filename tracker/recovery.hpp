#pragma once

#include <array>
#include <optional>
#include <vector>

#include "tracker/end_to_end_search.hpp"
#include "tracker/mode_search.hpp"
#include "tracker/stereo_tracker.hpp"
#include "tracker/thread_finder.hpp"
#include "tracker/thread_tracker.hpp"

namespace atropos::tracker {

/// Finds a curve again by discrete search, where continuous refinement has no gradient to follow: the paper's
/// E2 (eq. 15-18) with exact dynamic programming and labels along the viewing rays, longer in depth. Coarse:
/// what it returns is to be refined. Large pictures are searched at 640 px.
class Recovery {
  public:
    Recovery(const scenes::TrackerConfig& config, const scenes::StereoRig& rig);

    /// In the neighbourhood of a curve.
    std::optional<NurbsCurve> near(const StereoFrame& frame, const NurbsCurve& curve);

    /// In the neighbourhood of a curve of `control_points` (3 x K) that deforms as was learned.
    std::optional<NurbsCurve> along_modes(const StereoFrame& frame, const Eigen::Matrix3Xd& control_points,
                                          double length_m, const DeformationModes& modes);

    /// Anywhere between two measured ends (III); nothing when an end is unknown or no thread is seen.
    std::optional<NurbsCurve> between_tips(const StereoFrame& frame);

    /// What the finder sees run from one measured end to the other, loops and all; where it doubts that, or
    /// the length is known and is another one, what the search of the way between the ends finds of that
    /// length.
    std::optional<NurbsCurve> traced(const StereoFrame& frame);

  private:
    const StereoFrame& small(const StereoFrame& frame);
    std::optional<NurbsCurve> between_ends();
    std::optional<NurbsCurve> curve_of(const std::vector<Eigen::Vector3d>& control_points) const;

    scenes::TrackerConfig config_;
    double shrinkage_;       ///< of the pictures that are searched
    scenes::StereoRig rig_;  ///< of those
    ThreadTracker search_;
    std::optional<ModeSearch> mode_search_;     ///< once it was asked for
    std::optional<ThreadFinder> finder_;        ///< likewise
    std::optional<EndToEndSearch> end_to_end_;  ///< likewise
    scenes::WorkerPool pool_;
    StereoFrame small_;
    std::array<cv::Mat, 2> shrunk_;
};

}  // namespace atropos::tracker
