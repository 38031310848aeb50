#include "tracker/thread_tracker.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include "tracker/label_set.hpp"
#include "tracker/thread_initialiser.hpp"

namespace atropos::tracker {
namespace {

constexpr double kReferenceWidth_px = 640.0;
constexpr double kSupport_px = 2.0;       // at 640: a sample nearer to a ridge than this is seen
constexpr double kTrackingSupport = 0.5;  // below it the curve is hardly seen
constexpr int kFramesToLost = 10;         // this long hardly seen: given up
constexpr double kSigmaLateral_px = 0.7;  // measured on the tests' sequences, docs/method.md
constexpr double kSigmaDisparity_px = 0.7;

double ms_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

double mean_depth_m(const std::vector<Eigen::Vector3d>& points) {
    double sum = 0.0;
    for (const Eigen::Vector3d& p : points) sum += p.z();
    return sum / static_cast<double>(points.size());
}

}  // namespace

ThreadTracker::ThreadTracker(const scenes::TrackerConfig& config, const scenes::StereoRig& rig)
    : config_(config),
      rig_(rig),
      eyes_(make_eyes(rig)),
      sampling_(config.curve.degree, config.curve.control_points, config.curve.samples),
      pool_(config.threads),
      search_(config.method, config.optimiser, config.labels, config.curve.control_points),
      sampler_(config.curve.degree, config.curve.control_points) {
    validate(config);
    const bool first = config.method == scenes::TrackerMethod::kE1;
    weights_ = {.px_scale = kReferenceWidth_px / rig.left.width_px,
                .length = first ? config.lambda1_e1 : config.lambda1_e2,
                .smooth_per_m = first ? config.lambda2_e1_per_m : 0.0,
                .tip_epsilon_m = config.tips.epsilon_m,
                .tip_per_m = config.tips.weight_per_m};
    result_.labels.resize(static_cast<std::size_t>(config.labels.steps * config.curve.control_points));
}

const TrackResult& ThreadTracker::start(const StereoFrame& frame, const NurbsCurve& initial) {
    check_frame(frame, rig_);
    if (initial.degree() != config_.curve.degree ||
        static_cast<int>(initial.control_points().size()) != config_.curve.control_points)
        throw std::invalid_argument("an initial curve of degree " + std::to_string(initial.degree()) +
                                    " with " + std::to_string(initial.control_points().size()) +
                                    " control points, expected " + std::to_string(config_.curve.degree) +
                                    " and " + std::to_string(config_.curve.control_points));
    begin(initial.control_points());
    return track(frame);
}

const TrackResult& ThreadTracker::track(const StereoFrame& frame) {
    const auto begin_time = std::chrono::steady_clock::now();
    timings_ = {};
    check_frame(frame, rig_);
    if (!state_.started && !begin_between_tips(frame)) return lost_result(frame);
    optimise(frame);
    judge(frame);
    timings_.total_ms = ms_since(begin_time);
    return result_;
}

void ThreadTracker::begin(const std::vector<Eigen::Vector3d>& control_points) {
    state_.started = true;
    state_.status = scenes::TrackStatus::kTracking;
    state_.frames_unseen = 0;
    state_.control_points = control_points;
    state_.reference_control_points = control_points;
    prepare_for_reference();
}

void ThreadTracker::restore(const TrackerState& state) {
    const std::size_t K = static_cast<std::size_t>(config_.curve.control_points);
    if (state.started && (state.control_points.size() != K || state.reference_control_points.size() != K))
        throw std::invalid_argument("a state of " + std::to_string(state.control_points.size()) +
                                    " control points, expected " + std::to_string(K));
    state_ = state;
    if (state_.started) prepare_for_reference();
}

// What follows from the initial curve alone: C'_ref (eq. 7), the spacing of labels and the detector's scale.
void ThreadTracker::prepare_for_reference() {
    reference_speed_m_.resize(static_cast<std::size_t>(sampling_.samples()));
    for (int j = 0; j < sampling_.samples(); ++j)
        reference_speed_m_[static_cast<std::size_t>(j)] =
            config_.thread.length_is_known ? config_.thread.length_m
                                           : sampling_.velocity(state_.reference_control_points, j).norm();
    const double depth_m = mean_depth_m(state_.reference_control_points);
    spacing_m_ = tracker::label_spacing_m(config_, rig_, depth_m);
    const int truncation_px = static_cast<int>(std::lround(std::min(
        config_.cost_image.truncation_px / weights_.px_scale, double(DistanceTransform::kMaxTruncation))));
    cost_images_.emplace(config_, ridge_scales_px(config_, 1.0 / rig_.m_per_px(depth_m)),
                         std::max(truncation_px, 1));
}

bool ThreadTracker::begin_between_tips(const StereoFrame& frame) {
    const std::optional<std::vector<Eigen::Vector3d>> found =
        initial_curve_between_tips(config_, rig_, frame, pool_);
    if (found) begin(*found);
    return found.has_value();
}

EnergyContext ThreadTracker::context(const StereoFrame& frame) const {
    return {sampling_, eyes_, cost_images_->costs(), reference_speed_m_, frame.tips, weights_};
}

// The curve's image grown by all that the labels can move it, so that nothing outside is looked at.
std::array<cv::Rect, 2> ThreadTracker::regions(const StereoFrame& frame) const {
    const cv::Size size = frame.left.size();
    if (!config_.cost_image.region_of_interest) return {cv::Rect({}, size), cv::Rect({}, size)};
    double nearest_m = state_.control_points[0].z();
    for (const Eigen::Vector3d& q : state_.control_points) nearest_m = std::min(nearest_m, q.z());
    double reach_m = 0.0;
    for (int step = 0; step < config_.labels.steps; ++step)
        reach_m += search_.reach_m(spacing_m_ * std::exp2(-step));
    // Labels along rays hardly move the image: their long axis doesn't count.
    if (config_.labels.shape == scenes::LabelShape::kRays)
        reach_m *= std::sqrt(3.0) / std::sqrt(2.0 + std::pow(config_.labels.depth_factor, 2));
    const double margin_px = reach_m / rig_.m_per_px(std::max(nearest_m, 0.01)) + 4.0;
    return {region_around(eyes_[0], state_.control_points, margin_px, size),
            region_around(eyes_[1], state_.control_points, margin_px, size)};
}

void ThreadTracker::optimise(const StereoFrame& frame) {
    for (std::size_t end = 0; end < 2; ++end)  // a fixed end is known exactly (III-B, the knot)
        if (frame.tips[end] && frame.tips[end]->kind == MeasuredTip::Kind::kFixed)
            (end == 0 ? state_.control_points.front() : state_.control_points.back()) = frame.tips[end]->p_C;
    const auto begin_time = std::chrono::steady_clock::now();
    cost_images_->make(frame, regions(frame), pool_);
    timings_.cost_images_ms = ms_since(begin_time);
    if (observer_) {
        cost_images_->show(*observer_);
        observer_->curve("before", state_.control_points);
    }
    const std::size_t K = state_.control_points.size();
    for (int step = 0; step < config_.labels.steps; ++step) {  // L(r, s), then L(r, s / 2)
        const std::span<int> labels =
            std::span(result_.labels).subspan(static_cast<std::size_t>(step) * K, K);
        search_.step(context(frame), spacing_m_ * std::exp2(-step), pool_, state_.control_points, labels,
                     timings_);
        if (observer_) show_step(*observer_, step, search_, labels, state_.control_points);
    }
}

void ThreadTracker::judge(const StereoFrame& frame) {
    result_.frame = frame.index;
    result_.energy = energy(context(frame), state_.control_points);
    result_.support = support(context(frame), state_.control_points, kSupport_px);
    state_.frames_unseen = result_.support >= kTrackingSupport ? 0 : state_.frames_unseen + 1;
    state_.status = state_.frames_unseen == 0              ? scenes::TrackStatus::kTracking
                    : state_.frames_unseen < kFramesToLost ? scenes::TrackStatus::kCoasting
                                                           : scenes::TrackStatus::kLost;
    state_.capture_time_s = frame.capture_time_s;
    result_.estimate.capture_time_s = frame.capture_time_s;
    result_.estimate.status = state_.status;
    result_.estimate.confidence = std::clamp(2.0 * result_.support - 0.8, 0.0, 1.0);
    if (state_.status == scenes::TrackStatus::kLost) {
        result_.control_points.clear();
        result_.estimate.samples.clear();
        return;
    }
    result_.control_points = state_.control_points;
    sampler_.sample(state_.control_points, result_.estimate.samples);
    for (scenes::ThreadSample& sample : result_.estimate.samples) {
        sample.sigma_lateral_m = kSigmaLateral_px / weights_.px_scale * rig_.m_per_px(sample.p_C.z());
        sample.sigma_depth_m =
            kSigmaDisparity_px / weights_.px_scale * rig_.m_per_disparity_px(sample.p_C.z());
    }
}

const TrackResult& ThreadTracker::lost_result(const StereoFrame& frame) {
    state_.capture_time_s = frame.capture_time_s;
    std::fill(result_.labels.begin(), result_.labels.end(), 0);
    result_.frame = frame.index;
    result_.estimate = {};
    result_.estimate.capture_time_s = frame.capture_time_s;
    result_.control_points.clear();
    result_.energy = {};
    result_.support = 0.0;
    return result_;
}

}  // namespace atropos::tracker
