#pragma once

#include <vector>

#include "scenes/tracker_config.hpp"
#include "tests/support/synthetic_sequence.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::support {

/// How a tracker did on one frame.
struct FrameScore {
    scenes::TrackStatus status;
    double accuracy_3d_m;   ///< eq. 20
    double accuracy_2d_px;  ///< eq. 21
    double symmetric_2d_px;
    double middle_m;
    double support;
    double total_ms;
    // Offsets of the samples to the truth across and along the viewing ray, in units of a pixel and of a
    // pixel of disparity, at 640.
    std::vector<double> lateral_px = {};
    std::vector<double> disparity_px = {};
};

/// A generated frame as a tracker gets it.
tracker::StereoFrame stereo_frame(const SyntheticFrame& frame, int index);

/// Runs the tracker of `config` over the first `frames` frames, from the true curve of frame 0, ends given.
std::vector<FrameScore> run_trial(const scenes::TrackerConfig& config,
                                  const SyntheticSequenceOptions& options, int frames);

/// Several trackers over the same frames.
std::vector<std::vector<FrameScore>> run_trials(const std::vector<scenes::TrackerConfig>& configs,
                                                const SyntheticSequenceOptions& options, int frames);

/// Means over frames, as the paper's Table I and `evaluate` count: lost frames left out of the means.
struct TrialSummary {
    int frames = 0;
    double mean_3d_m = 0.0, std_3d_m = 0.0;
    double mean_2d_px = 0.0, std_2d_px = 0.0, median_2d_px = 0.0;
    double failed_percent = 0.0;  ///< frames with symmetric 2D error above 5 px, at 640, any status
    int lost_frames = 0;          ///< status lost
};
TrialSummary summary(const std::vector<FrameScore>& scores, double failure_px = 5.0);

/// Offsets of one kind (`&FrameScore::lateral_px` or `disparity_px`) of all samples of frames that aren't
/// lost.
using OffsetKind = std::vector<double> FrameScore::*;
/// The share of them that is at most `px`.
double share_within(const std::vector<FrameScore>& scores, OffsetKind kind, double px);
/// The offset that `share` of them does not exceed; 0 of none.
double offset_quantile_px(const std::vector<FrameScore>& scores, OffsetKind kind, double share);

/// How far the knot points (the curve at its six distinct knots) move from frame to frame: the deformation
/// columns of Table I.
struct KnotMotion {
    double mean_3d_m = 0.0, max_3d_m = 0.0;
    double mean_2d_px = 0.0, max_2d_px = 0.0;  ///< over both eyes
};
KnotMotion knot_motion(const SyntheticSequenceOptions& options, int frames);

}  // namespace atropos::support
