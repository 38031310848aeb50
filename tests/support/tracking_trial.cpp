#include "tests/support/tracking_trial.hpp"

#include <algorithm>
#include <cmath>

#include "tracker/curve_distance.hpp"

namespace atropos::support {
namespace {

/// Every fourth point: chords of 0.7 mm, within 2 um of the curve.
scenes::Polyline thinned(const scenes::Polyline& line) {
    scenes::Polyline thin;
    for (std::size_t i = 0; i < line.points.size(); i += 4) thin.points.push_back(line.points[i]);
    return thin;
}

double mean_nearest(const scenes::Polyline& from, const scenes::Polyline& to) {
    double sum = 0.0;
    for (const Eigen::Vector3d& p : from.points) sum += to.nearest(p).distance_m;
    return sum / static_cast<double>(from.points.size());
}

}  // namespace

tracker::StereoFrame stereo_frame(const SyntheticFrame& frame, int index) {
    tracker::StereoFrame out;
    out.index = index;
    out.capture_time_s = frame.time_s;
    out.left = frame.left;
    out.right = frame.right;
    for (std::size_t end = 0; end < 2; ++end) out.tips[end] = tracker::MeasuredTip{.p_C = frame.tips_C[end]};
    out.instruments = frame.instruments_C;
    return out;
}

namespace {

FrameScore score_of(const tracker::TrackResult& result, const SyntheticFrame& drawn,
                    const scenes::StereoRig& rig) {
    FrameScore score{result.estimate.status, 0.0, 0.0, 1e9, 0.0, result.support, 0.0};
    if (result.estimate.samples.empty()) return score;
    scenes::Polyline found;
    for (const scenes::ThreadSample& sample : result.estimate.samples) found.points.push_back(sample.p_C);
    const scenes::Polyline truth = thinned(drawn.truth_C);
    const double n = static_cast<double>(found.points.size()), px_scale = 640.0 / rig.left.width_px;
    for (const scenes::ThreadSample& sample : result.estimate.samples) {
        const scenes::Polyline::Nearest nearest = truth.nearest(sample.p_C);
        score.accuracy_3d_m += nearest.distance_m / n;
        const Eigen::Vector3d offset = sample.p_C - nearest.point, ray = sample.p_C.normalized();
        const double depth_m = std::abs(offset.dot(ray)), lateral_m = offset.cross(ray).norm();
        score.lateral_px.push_back(px_scale * lateral_m / rig.m_per_px(sample.p_C.z()));
        score.disparity_px.push_back(px_scale * depth_m / rig.m_per_disparity_px(sample.p_C.z()));
    }
    score.middle_m = tracker::arc_length_distance(found, drawn.truth_C).middle_m;
    score.symmetric_2d_px = 0.0;
    for (int eye = 0; eye < 2; ++eye) {
        const scenes::Polyline a = tracker::image_of(found, rig, eye);
        const scenes::Polyline b = tracker::image_of(truth, rig, eye);
        const double forth = mean_nearest(a, b);
        score.accuracy_2d_px += 0.5 * forth;
        score.symmetric_2d_px += 0.25 * (forth + mean_nearest(b, a));
    }
    return score;
}

}  // namespace

std::vector<FrameScore> run_trial(const scenes::TrackerConfig& config,
                                  const SyntheticSequenceOptions& options, int frames) {
    return run_trials({config}, options, frames).front();
}

std::vector<std::vector<FrameScore>> run_trials(const std::vector<scenes::TrackerConfig>& configs,
                                                const SyntheticSequenceOptions& options, int frames) {
    const SyntheticSequence sequence(options);
    std::vector<std::unique_ptr<tracker::StereoTracker>> trackers;
    for (const scenes::TrackerConfig& config : configs)
        trackers.push_back(tracker::make_tracker(config, options.rig));
    std::vector<std::vector<FrameScore>> scores(configs.size());
    for (int i = 0; i < frames; ++i) {
        const SyntheticFrame drawn = sequence.frame(i);
        const tracker::StereoFrame frame = stereo_frame(drawn, i);
        for (std::size_t t = 0; t < trackers.size(); ++t) {
            if (i == 0)
                trackers[t]->start(
                    frame,
                    tracker::fit_curve(drawn.truth_C, {.degree = configs[t].curve.degree,
                                                       .control_points = configs[t].curve.control_points,
                                                       .length_weight = 1.0}));
            const tracker::TrackResult& result = trackers[t]->track(frame);
            scores[t].push_back(score_of(result, drawn, options.rig));
            scores[t].back().total_ms = trackers[t]->timings().total_ms;
        }
    }
    return scores;
}

TrialSummary summary(const std::vector<FrameScore>& scores, double failure_px) {
    TrialSummary s;
    s.frames = static_cast<int>(scores.size());
    std::vector<double> px;
    double sum_m = 0.0, square_m = 0.0, sum_px = 0.0, square_px = 0.0;
    int failed = 0;
    for (const FrameScore& score : scores) {
        failed += score.symmetric_2d_px > failure_px ? 1 : 0;
        if (score.status == scenes::TrackStatus::kLost) {
            ++s.lost_frames;
            continue;
        }
        px.push_back(score.accuracy_2d_px);
        sum_m += score.accuracy_3d_m;
        square_m += score.accuracy_3d_m * score.accuracy_3d_m;
        sum_px += score.accuracy_2d_px;
        square_px += score.accuracy_2d_px * score.accuracy_2d_px;
    }
    s.failed_percent = 100.0 * failed / std::max(s.frames, 1);
    if (px.empty()) return s;
    const double n = static_cast<double>(px.size());
    s.mean_3d_m = sum_m / n;
    s.std_3d_m = std::sqrt(std::max(0.0, square_m / n - s.mean_3d_m * s.mean_3d_m));
    s.mean_2d_px = sum_px / n;
    s.std_2d_px = std::sqrt(std::max(0.0, square_px / n - s.mean_2d_px * s.mean_2d_px));
    std::nth_element(px.begin(), px.begin() + static_cast<std::ptrdiff_t>(px.size() / 2), px.end());
    s.median_2d_px = px[px.size() / 2];
    return s;
}

namespace {

std::vector<double> offsets_px(const std::vector<FrameScore>& scores, OffsetKind kind) {
    std::vector<double> all;
    for (const FrameScore& score : scores)
        if (score.status != scenes::TrackStatus::kLost)
            all.insert(all.end(), (score.*kind).begin(), (score.*kind).end());
    return all;
}

}  // namespace

double share_within(const std::vector<FrameScore>& scores, OffsetKind kind, double px) {
    const std::vector<double> offsets = offsets_px(scores, kind);
    const auto within = std::count_if(offsets.begin(), offsets.end(), [&](double o) { return o <= px; });
    return static_cast<double>(within) / static_cast<double>(std::max<std::size_t>(offsets.size(), 1));
}

double offset_quantile_px(const std::vector<FrameScore>& scores, OffsetKind kind, double share) {
    std::vector<double> offsets = offsets_px(scores, kind);
    if (offsets.empty()) return 0.0;
    const auto at =
        offsets.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(offsets.size() - 1));
    std::nth_element(offsets.begin(), at, offsets.end());
    return *at;
}

KnotMotion knot_motion(const SyntheticSequenceOptions& options, int frames) {
    constexpr int kKnots = 6;
    const SyntheticThread thread(options);
    const scenes::StereoRig& rig = options.rig;
    KnotMotion motion;
    std::vector<Eigen::Vector3d> before;
    for (int i = 0; i < frames; ++i) {
        const scenes::Polyline truth = thread.truth(i);
        std::vector<Eigen::Vector3d> knots;
        for (std::size_t k = 0; k < kKnots; ++k)
            knots.push_back(truth.points[k * (truth.points.size() - 1) / (kKnots - 1)]);
        for (std::size_t k = 0; k < before.size(); ++k) {
            const double moved_m = (knots[k] - before[k]).norm();
            const double left_px = (rig.project_left(knots[k]) - rig.project_left(before[k])).norm();
            const double right_px = (rig.project_right(knots[k]) - rig.project_right(before[k])).norm();
            motion.mean_3d_m += moved_m;
            motion.mean_2d_px += 0.5 * (left_px + right_px);
            motion.max_3d_m = std::max(motion.max_3d_m, moved_m);
            motion.max_2d_px = std::max({motion.max_2d_px, left_px, right_px});
        }
        before = std::move(knots);
    }
    const double steps = static_cast<double>(kKnots * std::max(frames - 1, 1));
    motion.mean_3d_m /= steps;
    motion.mean_2d_px /= steps;
    return motion;
}

}  // namespace atropos::support
