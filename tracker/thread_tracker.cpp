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
constexpr int kRestartFrames = 10;        // a lost thread is looked for between its ends this often

/// Within which 68 % of the offsets lie, at 640: `tracker_table sigmas default` (docs/method.md).
constexpr scenes::TrackerConfig::Uncertainty kOfE1 = {1.9, 0.49}, kOfE2 = {1.3, 0.40};

double ms_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

double mean_depth_m(const std::vector<Eigen::Vector3d>& points) {
    double sum = 0.0;
    for (const Eigen::Vector3d& p : points) sum += p.z();
    return sum / static_cast<double>(points.size());
}

int labels_per_node(const scenes::TrackerConfig& config) {
    return config.parameterisation == scenes::Parameterisation::k2d
               ? ImageUnknowns::labels_per_node(config.labels.r)
               : 14 * config.labels.r + 1;
}

}  // namespace

scenes::TrackerConfig::Uncertainty stated_uncertainty(const scenes::TrackerConfig& config) {
    scenes::TrackerConfig::Uncertainty stated = config.uncertainty;
    const auto own = config.method == scenes::TrackerMethod::kE1 ? kOfE1 : kOfE2;
    if (stated.lateral_px == 0.0) stated.lateral_px = own.lateral_px;
    if (stated.disparity_px == 0.0) stated.disparity_px = own.disparity_px;
    return stated;
}

ThreadTracker::ThreadTracker(const scenes::TrackerConfig& config, const scenes::StereoRig& rig)
    : config_(config),
      rig_(rig),
      eyes_(make_eyes(rig)),
      sampling_(config.curve.degree, config.curve.control_points, config.curve.samples),
      pool_(config.threads),
      search_(config.method, config.optimiser, config.labels, config.curve.control_points,
              labels_per_node(config)),
      sampler_(config.curve.degree, config.curve.control_points),
      uncertainty_(stated_uncertainty(config)) {
    validate(config);
    const bool first = config.method == scenes::TrackerMethod::kE1;
    weights_ = {.px_scale = kReferenceWidth_px / rig.left.width_px,
                .length = first ? config.lambda1_e1 : config.lambda1_e2,
                .smooth_per_m = first ? config.lambda2_e1_per_m : 0.0,
                .tip_epsilon_m = config.tips.epsilon_m,
                .tip_per_m = config.tips.weight_per_m};
    if (config.parameterisation == scenes::Parameterisation::k2d) image_unknowns_.emplace(rig, config);
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
    // A lost thread is looked for where it was last seen and, now and then, anew from both ends.
    if (state_.status == scenes::TrackStatus::kLost && state_.frames_unseen % kRestartFrames == 0)
        begin_between_tips(frame);
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
    if (image_unknowns_) image_unknowns_->begin(control_points);
    prepare_for_reference();
}

TrackerState ThreadTracker::state() const {
    TrackerState state = state_;
    if (image_unknowns_ && state.started) state.method_state = image_unknowns_->state();
    return state;
}

void ThreadTracker::restore(const TrackerState& state) {
    const std::size_t K = static_cast<std::size_t>(config_.curve.control_points);
    if (state.started && (state.control_points.size() != K || state.reference_control_points.size() != K))
        throw std::invalid_argument("a state of " + std::to_string(state.control_points.size()) +
                                    " control points, expected " + std::to_string(K));
    state_ = state;
    if (image_unknowns_ && state.started) image_unknowns_->restore(state.method_state);
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
    return {sampling_,
            eyes_,
            cost_images_->costs(),
            reference_speed_m_,
            frame.tips,
            weights_,
            image_unknowns_ ? &image_unknowns_->points() : nullptr};
}

// Costs are made only where the placed labels can move the curve: nothing else is looked at.
void ThreadTracker::want_reached_pixels(const StereoFrame& frame) {
    const EnergyContext now = context(frame);
    for (int eye = 0; eye < 2; ++eye) {
        if (!config_.cost_image.region_of_interest) {
            cost_images_->want(eye, {0, 0, frame.left.cols, frame.left.rows});
            continue;
        }
        for (int j = 0; j < sampling_.samples(); ++j)
            cost_images_->want(eye,
                               search_.reach(now, static_cast<std::size_t>(eye), state_.control_points, j));
    }
}

void ThreadTracker::optimise(const StereoFrame& frame) {
    for (std::size_t end = 0; end < 2; ++end)  // a fixed end is known exactly (III-B, the knot)
        if (frame.tips[end] && frame.tips[end]->kind == MeasuredTip::Kind::kFixed)
            (end == 0 ? state_.control_points.front() : state_.control_points.back()) = frame.tips[end]->p_C;
    if (image_unknowns_) image_unknowns_->fix_ends(frame.tips);
    auto begin_time = std::chrono::steady_clock::now();
    cost_images_->begin(frame);
    if (observer_) {
        cost_images_->show(*observer_);
        observer_->curve("before", state_.control_points);
    }
    const std::size_t K = state_.control_points.size();
    for (int step = 0; step < config_.labels.steps; ++step) {  // L(r, s), then L(r, s / 2)
        const std::span<int> labels =
            std::span(result_.labels).subspan(static_cast<std::size_t>(step) * K, K);
        const double s_m = spacing_m_ * std::exp2(-step);
        if (image_unknowns_)
            image_unknowns_->place_labels(state_.control_points, s_m, search_.labels());
        else
            search_.place_labels(state_.control_points, s_m, eyes_);
        want_reached_pixels(frame);
        cost_images_->compute(pool_);
        timings_.cost_images_ms += ms_since(begin_time);
        search_.minimise(context(frame), pool_, state_.control_points, labels, timings_);
        if (image_unknowns_) image_unknowns_->move(search_.labels(), labels);
        begin_time = std::chrono::steady_clock::now();
        if (observer_) show_step(*observer_, step, search_, labels, state_.control_points);
    }
}

void ThreadTracker::judge(const StereoFrame& frame) {
    result_.frame = frame.index;
    result_.energy = energy(context(frame), state_.control_points);
    if (image_unknowns_) {
        result_.energy.stereo = image_unknowns_->stereo_energy();
        result_.energy.total += result_.energy.stereo;
    }
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
        sample.sigma_lateral_m = uncertainty_.lateral_px / weights_.px_scale * rig_.m_per_px(sample.p_C.z());
        sample.sigma_depth_m =
            uncertainty_.disparity_px / weights_.px_scale * rig_.m_per_disparity_px(sample.p_C.z());
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
