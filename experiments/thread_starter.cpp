#include "experiments/thread_starter.hpp"

#include "tracker/nurbs_curve.hpp"

namespace atropos::experiments {

ThreadStarter::ThreadStarter(const scenes::TrackerConfig& config, const scenes::StereoRig& rig,
                             const std::optional<Eigen::Vector2d>& seed_px)
    : config_(config), finder_(rig, tracker::finder_options(config)), seed_px_(seed_px) {}

const tracker::TrackResult& ThreadStarter::track(tracker::StereoTracker& tracker,
                                                 const tracker::StereoFrame& frame) {
    const tracker::TrackResult& result = tracker.track(frame);
    constexpr int kPatience = 10;  // frames without sight of the thread
    const bool unseen = result.estimate.status != scenes::TrackStatus::kTracking;
    unseen_frames_ = unseen ? unseen_frames_ + 1 : 0;
    const bool wanted = result.estimate.status == scenes::TrackStatus::kLost || unseen_frames_ > kPatience;
    if (!wanted || frame.tips[0] || frame.tips[1]) return result;
    const std::optional<tracker::FoundThread> found = finder_.find(frame, seed_px_);
    if (!found || found->doubt != tracker::Doubt::kNone) return result;
    seed_px_.reset();
    return tracker.start(frame, fitting(found->curve));
}

// The paper's methods take curves of their own degree and number of control points alone.
tracker::NurbsCurve ThreadStarter::fitting(const tracker::NurbsCurve& curve) const {
    if (config_.method == scenes::TrackerMethod::kRefined) return curve;
    return tracker::fit_curve(tracker::sampled(curve, 200), {.degree = config_.curve.degree,
                                                             .control_points = config_.curve.control_points,
                                                             .length_weight = 0.1});
}

}  // namespace atropos::experiments
