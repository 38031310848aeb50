#include "experiments/thread_starter.hpp"

#include "tracker/nurbs_curve.hpp"

namespace atropos::experiments {

ThreadStarter::ThreadStarter(const scenes::TrackerConfig& config, const scenes::StereoRig& rig,
                             const std::optional<Eigen::Vector2d>& seed_px)
    : config_(config), finder_(rig, tracker::finder_options(config)), seed_px_(seed_px) {}

const tracker::TrackResult& ThreadStarter::track(tracker::StereoTracker& tracker,
                                                 const tracker::StereoFrame& frame) {
    if (frame.tips[0] || frame.tips[1]) return tracker.track(frame);
    constexpr int kPatience = 10;  // frames without sight of the thread
    const std::optional<tracker::FoundThread> found = finder_.find(frame, seed_px_);
    const bool sure = found && found->doubt == tracker::Doubt::kNone;
    const tracker::StereoFrame seen = sure ? with_ends(frame, *found) : frame;
    const tracker::TrackResult& result = tracker.track(seen);
    const scenes::TrackStatus status = result.estimate.status;
    unseen_frames_ = status == scenes::TrackStatus::kTracking ? 0 : unseen_frames_ + 1;
    if (!sure || (status != scenes::TrackStatus::kLost && unseen_frames_ <= kPatience)) return result;
    seed_px_.reset();
    return tracker.start(seen, fitting(found->curve));
}

// Ends that nobody measures slide along the thread unless they are seen.
tracker::StereoFrame ThreadStarter::with_ends(const tracker::StereoFrame& frame,
                                              const tracker::FoundThread& found) {
    std::array<Eigen::Vector3d, 2> ends{found.samples.front().p_C, found.samples.back().p_C};
    if (ends_C_) {  // the same way along the thread as before
        const auto& [first, last] = *ends_C_;
        if ((ends[0] - last).norm() + (ends[1] - first).norm() <
            (ends[0] - first).norm() + (ends[1] - last).norm())
            std::swap(ends[0], ends[1]);
    }
    ends_C_ = ends;
    tracker::StereoFrame known = frame;
    for (std::size_t end = 0; end < 2; ++end)
        known.tips[end] = tracker::MeasuredTip{ends[end], tracker::MeasuredTip::Kind::kSeen};
    return known;
}

// The paper's methods take curves of their own degree and number of control points alone.
tracker::NurbsCurve ThreadStarter::fitting(const tracker::NurbsCurve& curve) const {
    if (config_.method == scenes::TrackerMethod::kRefined) return curve;
    return tracker::fit_curve(tracker::sampled(curve, 200), {.degree = config_.curve.degree,
                                                             .control_points = config_.curve.control_points,
                                                             .length_weight = 0.1});
}

}  // namespace atropos::experiments
