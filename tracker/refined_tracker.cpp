#include "tracker/refined_tracker.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <string>

#include "tracker/curve_uncertainty.hpp"
#include "tracker/occlusion_mask.hpp"

namespace atropos::tracker {
namespace {

constexpr double kVelocityDamping = 0.5;
constexpr double kBehind_m = 0.003;
constexpr double kLeastSigma_px =
    0.03;  ///< texture under the thread, lens model: what noise does not explain

constexpr double kEndRobustSigmas = 6.0;

EndBelief::Options belief_options(const scenes::TrackerConfig& config) {
    return {.bias_sigma_m = config.refined.tip_bias_sigma_m, .jitter_sigma_m = config.refined.tip_sigma_m};
}

double elapsed_ms(std::chrono::steady_clock::time_point since) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - since).count();
}

}  // namespace

RefinedTracker::RefinedTracker(const scenes::TrackerConfig& config, const scenes::StereoRig& rig)
    : RefinedTracker(config, rig, CurvePriors{}) {}

RefinedTracker::RefinedTracker(const scenes::TrackerConfig& config, const scenes::StereoRig& rig,
                               const CurvePriors& priors)
    : config_(config),
      rig_(rig),
      scale_(rig.left.width_px / 640.0),
      refinement_(config.refined.control_points, config.refined.samples, priors, rig),
      filter_({.polarity = config.thread.polarity,
               .threshold_levels = config.refined.contrast_levels,
               .blur_px = config.refined.blur_px,
               .taps = 5,
               .tap_step_px = std::max(1.0, scale_)}),
      recovery_(config, rig),
      grip_sight_(rig, filter_.options(), config.thread.width_m),
      ends_{EndBelief(belief_options(config)), EndBelief(belief_options(config))} {
    validate(config);
    const std::size_t samples = static_cast<std::size_t>(config.refined.samples);
    const int K = config.refined.control_points;
    loss_test_.residual_px *= scale_;
    fit_.Q.setZero(3, K);
    trial_.Q.setZero(3, K);
    problem_.expected.setZero(3, K);
    velocity_m_s_.setZero(3, K);
    covariance_.setZero(3 * K, 3 * K);
    for (std::size_t eye = 0; eye < 2; ++eye) {
        problem_.lines[eye].resize(samples);
        expected_depth_levels_[eye].assign(samples, 0.0);
    }
    candidates_.resize(samples);
    lines_.resize(samples);
    widths_px_.resize(samples);
    noises_.reserve(2 * samples);
}

RefinedTracker::~RefinedTracker() = default;

const TrackResult& RefinedTracker::start(const StereoFrame& frame, const NurbsCurve& initial) {
    check_frame(frame, rig_);
    for (EndBelief& end : ends_) end.reset();
    begin(initial);
    return track(frame);
}

void RefinedTracker::begin(const NurbsCurve& initial) {
    fit_.Q = control_points_of(initial);
    const bool known = config_.thread.length_m > 0.0;
    expected_length_m_ = known ? config_.thread.length_m : initial.length();
    expected_length_sigma_m_ = known ? config_.refined.length_sigma_m : 0.03 * expected_length_m_;
    fit_.length_m = expected_length_m_;
    velocity_m_s_.setZero();
    last_tips_C_ = {};
    for (auto& depths : expected_depth_levels_) std::fill(depths.begin(), depths.end(), 0.0);
    started_ = confirmed_ = true;
    status_ = scenes::TrackStatus::kTracking;
    frames_unseen_ = 0;
    capture_time_s_ = -1.0;
}

// The ends' measured motion carries the curve linearly along it, free of the ends' constant error; what else
// the control points did lately goes on, damped.
void RefinedTracker::predict(const StereoFrame& frame) {
    const int K = config_.refined.control_points;
    const double dt =
        capture_time_s_ < 0.0 ? 0.0 : std::clamp(frame.capture_time_s - capture_time_s_, 0.0, 1.0);
    Eigen::Vector3d moved[2] = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    for (std::size_t end = 0; end < 2; ++end)
        if (frame.tips[end] && last_tips_C_[end]) moved[end] = frame.tips[end]->p_C - *last_tips_C_[end];
    for (int k = 0; k < K; ++k) {
        const double u = static_cast<double>(k) / (K - 1);
        problem_.expected.col(k) = fit_.Q.col(k) + (1.0 - u) * moved[0] + u * moved[1] +
                                   kVelocityDamping * dt * velocity_m_s_.col(k);
    }
    for (EndBelief& end : ends_) end.wait(dt);
    place_instruments(frame);
    expect_ends(frame);
    problem_.length_m = expected_length_m_;
    problem_.length_sigma_m = expected_length_sigma_m_;
}

// An instrument that holds an end is wrong by as much as the end.
void RefinedTracker::place_instruments(const StereoFrame& frame) {
    instruments_C_ = frame.instruments;
    for (std::size_t end = 0; end < 2; ++end) {
        if (!frame.tips[end] || frame.tips[end]->kind == MeasuredTip::Kind::kFixed) continue;
        for (std::size_t i = 0; i < instruments_C_.size(); ++i) {
            if (scenes::clearance_m(frame.instruments[i], frame.tips[end]->p_C) > GripSight::kSameArm_m)
                continue;
            instruments_C_[i].a += ends_[end].bias_C();
            instruments_C_[i].b += ends_[end].bias_C();
        }
    }
}

// The measured ends without what their arms are known to be off by.
void RefinedTracker::expect_ends(const StereoFrame& frame) {
    for (std::size_t end = 0; end < 2; ++end) {
        grips_[end].reset();
        problem_.ends[end].reset();
        if (!frame.tips[end]) continue;
        if (frame.tips[end]->kind == MeasuredTip::Kind::kFixed) {
            problem_.ends[end] = end_prior(*frame.tips[end], 0.0);
            continue;
        }
        expected_ends_[end] = ends_[end].expected(frame.tips[end]->p_C);
        problem_.ends[end] =
            EndPrior{expected_ends_[end].p_C, expected_ends_[end].covariance.inverse(), kEndRobustSigmas};
    }
}

// Where along the thread the jaws are, as the images show it, joins what is expected of the ends.
void RefinedTracker::look_at_grips(const StereoFrame& frame, const Fit& fit) {
    expect_ends(frame);
    for (std::size_t end = 0; end < 2; ++end) {
        if (!frame.tips[end] || frame.tips[end]->kind == MeasuredTip::Kind::kFixed) continue;
        const int k = end == 0 ? 0 : config_.refined.control_points - 1;
        const Eigen::Vector3d outwards = (fit.Q.col(k) - fit.Q.col(end == 0 ? 1 : k - 1)).normalized();
        const UncertainPoint& expected = expected_ends_[end];
        GripQuery query;
        query.end = end;
        query.measured_C = frame.tips[end]->p_C;
        query.instruments_C = frame.instruments;
        query.expected_m = outwards.dot(expected.p_C - fit.Q.col(k));
        query.sigma_m = std::sqrt(outwards.dot(expected.covariance * outwards));
        query.excess_m = ends_[end].excess_m();
        query.excess_variance_m2 = ends_[end].excess_variance_m2();
        grips_[end] = grip_sight_.look(images_, refinement_.basis(), fit.Q, fit.length_m, query);
        if (!grips_[end]) continue;
        EndPrior& prior = *problem_.ends[end];
        const Eigen::Vector3d seen_C = fit.Q.col(k) + grips_[end]->offset_m * outwards;
        const Eigen::Matrix3d along =
            outwards * outwards.transpose() / (grips_[end]->sigma_m * grips_[end]->sigma_m);
        const Eigen::Matrix3d both = prior.information + along;
        prior.p_C = both.inverse() * (prior.information * prior.p_C + along * seen_C);
        prior.information = both;
    }
}

void RefinedTracker::measure_eye(const Fit& fit, std::size_t eye, const Round& round) {
    const double search_px = round.search_px * scale_;
    const scenes::Camera& camera = eye == 0 ? rig_.left : rig_.right;
    const Eigen::Vector3d eye_C =
        eye == 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(rig_.X_RC.inverse().translation());
    const OcclusionMask mask(instruments_C_, eye_C, 2.0 * config_.refined.instrument_sigma_m, kBehind_m);
    const std::vector<CubicBasisValues>& samples = refinement_.samples();
    std::vector<LineMeasurement>& measured = problem_.lines[eye];
    for (std::size_t j = 0; j < samples.size(); ++j) {
        candidates_[j].count = 0;
        candidates_[j].expected_depth_levels = expected_depth_levels_[eye][j];
        measured[j].kind = LineMeasurement::Kind::kHidden;
        const Eigen::Vector3d p_C = samples[j].point(fit.Q);
        const Eigen::Vector3d p = eye == 0 ? p_C : Eigen::Vector3d(rig_.X_RC * p_C);
        if (p.z() < 0.005) continue;
        Eigen::Vector3d tangent = samples[j].tangent(fit.Q);
        if (eye == 1) tangent = rig_.X_RC.linear() * tangent;
        Eigen::Matrix<double, 2, 3> J_px;
        NormalLine& line = lines_[j];
        line.p_px = camera.project(p, J_px);
        const Eigen::Vector2d along = J_px * tangent;
        const double speed = along.norm();
        // Seen end on, the thread has no direction in the image.
        if (!camera.contains(line.p_px) || speed < 0.15 * J_px.leftCols<2>().norm() * tangent.norm() * 0.7)
            continue;
        if (mask.hides(p_C)) continue;
        measured[j].kind = LineMeasurement::Kind::kMissing;
        line.tangent = along / speed;
        line.normal = {-line.tangent.y(), line.tangent.x()};
        widths_px_[j] = config_.thread.width_m * camera.fx_px / p.z();
        candidates_[j].count = filter_.find(images_[eye], line, search_px, widths_px_[j],
                                            candidates_[j].valleys, round.threshold_share);
        if (mask.empty()) continue;
        // A valley that lies on an instrument is its rim or its gloss.
        const Eigen::Matrix2d px_to_m = J_px.leftCols<2>().inverse();
        int kept = 0;
        for (int c = 0; c < candidates_[j].count; ++c) {
            const Valley& valley = candidates_[j].valleys[static_cast<std::size_t>(c)];
            Eigen::Vector3d shift = Eigen::Vector3d::Zero();
            shift.head<2>() = px_to_m * (valley.offset_px * line.normal);
            if (eye == 1) shift = rig_.X_RC.linear().transpose() * shift;
            if (!mask.hides(p_C + shift)) candidates_[j].valleys[static_cast<std::size_t>(kept++)] = valley;
        }
        candidates_[j].count = kept;
    }
    ValleyAssociationOptions options;
    options.search_px = search_px;
    options.jump_px = scale_ * 80.0 / static_cast<double>(samples.size());
    const std::span<const int> chosen =
        association_.choose(candidates_, round.threshold_share * config_.refined.contrast_levels, options);
    for (std::size_t j = 0; j < samples.size(); ++j) {
        if (chosen[j] < 0) continue;
        const Valley& valley = candidates_[j].valleys[static_cast<std::size_t>(chosen[j])];
        LineMeasurement& m = measured[j];
        m.kind = LineMeasurement::Kind::kSeen;
        m.point_px = lines_[j].p_px + valley.offset_px * lines_[j].normal;
        m.normal = lines_[j].normal;
        m.depth_levels = valley.depth_levels;
        m.sigma_px = 0.05;
    }
    if (round.closely) localise(eye);
}

// Replaces the valleys' positions by the least-squares ones, with sigmas from the image's own noise.
void RefinedTracker::localise(std::size_t eye) {
    noises_.clear();
    std::vector<LineMeasurement>& measured = problem_.lines[eye];
    for (std::size_t j = 0; j < measured.size(); ++j) {
        LineMeasurement& m = measured[j];
        if (m.kind != LineMeasurement::Kind::kSeen) continue;
        NormalLine line = lines_[j];
        line.p_px = m.point_px;
        ValleyFilter::Localisation found;
        if (!filter_.localise(images_[eye], line, widths_px_[j], found) ||
            std::abs(found.offset_px) > 0.5 * widths_px_[j] + 1.0 ||
            found.contrast_levels <
                std::max(config_.refined.contrast_levels, 4.0 * found.contrast_sigma_levels)) {
            m.kind = LineMeasurement::Kind::kMissing;
            continue;
        }
        m.point_px += found.offset_px * m.normal;
        m.sigma_px = found.sigma_px_per_noise_level;
        noises_.push_back(found.noise_levels);
    }
    if (noises_.empty()) return;
    const auto middle = noises_.begin() + static_cast<std::ptrdiff_t>(noises_.size() / 2);
    std::nth_element(noises_.begin(), middle, noises_.end());
    for (LineMeasurement& m : measured)
        if (m.kind == LineMeasurement::Kind::kSeen)
            m.sigma_px = std::hypot(m.sigma_px * *middle, kLeastSigma_px);
}

void RefinedTracker::measure(const Fit& fit, const Round& round) {
    for (std::size_t eye = 0; eye < 2; ++eye) measure_eye(fit, eye, round);
}

void RefinedTracker::refine(const StereoFrame& frame, double first_search_px, Fit& fit) {
    const Round rounds[] = {{first_search_px, 2.0, 3, 1.0, false},
                            {0.6 * config_.refined.search_px, 1.0, 2, 0.8, false},
                            {0.33 * config_.refined.search_px, 0.5, 2, 0.5, false},
                            {0.25 * config_.refined.search_px, 0.5, 2, 0.3, true}};
    expect_ends(frame);
    for (const Round& round : rounds) {
        if (round.closely) look_at_grips(frame, fit);
        measure(fit, round);
        problem_.robust_px = round.robust_px * scale_;
        refinement_.refine(problem_, round.iterations, fit.Q, fit.length_m);
    }
    fit.quality = judge_fit(problem_.lines, refinement_.samples(), fit.Q, fit.length_m, rig_, loss_test_);
}

const TrackResult& RefinedTracker::track(const StereoFrame& frame) {
    const auto began = std::chrono::steady_clock::now();
    timings_ = {};
    check_frame(frame, rig_);
    if (!started_ && !start_from_tips(frame)) return lost(frame);
    images_[0] = channel_view(frame.left, config_.thread.channel, buffers_[0]);
    images_[1] = channel_view(frame.right, config_.thread.channel, buffers_[1]);
    predict(frame);
    show("before", problem_.expected);
    expected_ = problem_.expected;
    fit_.Q = expected_;
    fit_.length_m = problem_.length_m;
    refine(frame, config_.refined.search_px, fit_);
    timings_.refinement_ms = elapsed_ms(began);
    if (is_lost(fit_.quality, loss_test_) && config_.refined.recovery) recover(frame);

    if (!confirmed_ && is_lost(fit_.quality, loss_test_)) return lost(frame);
    confirmed_ = true;

    const double dt = capture_time_s_ < 0.0 ? 0.0 : frame.capture_time_s - capture_time_s_;
    if (dt > 0.0) velocity_m_s_ = kVelocityDamping * velocity_m_s_ + (fit_.Q - expected_) / dt;
    show("refined", fit_.Q);
    conclude(frame);
    timings_.total_ms = elapsed_ms(began);
    return result_;
}

Eigen::Matrix3Xd RefinedTracker::control_points_of(const NurbsCurve& curve) const {
    const int K = config_.refined.control_points;
    const NurbsCurve fitted =
        fit_curve(sampled(curve, 8 * K), {.degree = 3, .control_points = K, .length_weight = 0.1});
    Eigen::Matrix3Xd Q(3, K);
    for (int k = 0; k < K; ++k) Q.col(k) = fitted.control_points()[static_cast<std::size_t>(k)];
    return Q;
}

NurbsCurve RefinedTracker::curve_of(const Eigen::Matrix3Xd& Q) const {
    std::vector<Eigen::Vector3d> points;
    for (int k = 0; k < Q.cols(); ++k) points.emplace_back(Q.col(k));
    return {3, std::move(points)};
}

// Refines from `curve`; `best` and its measurements are replaced when the images bear out the new fit better.
void RefinedTracker::try_fit(const StereoFrame& frame, const NurbsCurve& curve, Fit& best) {
    chosen_problem_ = problem_;
    other_.Q = control_points_of(curve);
    other_.length_m = expected_length_m_;
    problem_.expected = other_.Q;
    refine(frame, 0.6 * config_.refined.search_px, other_);
    if (!is_lost(other_.quality, loss_test_) && other_.quality.score() > best.quality.score())
        std::swap(best, other_);
    else
        std::swap(problem_, chosen_problem_);
}

// First about the prediction, then about the last curve, and after some blind frames between the measured
// ends.
void RefinedTracker::recover(const StereoFrame& frame) {
    const auto began = std::chrono::steady_clock::now();
    const Eigen::Matrix3Xd expected = problem_.expected;
    if (const auto found = recovery_.near(frame, curve_of(expected))) try_fit(frame, *found, fit_);
    if (is_lost(fit_.quality, loss_test_) && frames_unseen_ % 5 == 4)
        if (const auto found = recovery_.between_tips(frame)) try_fit(frame, *found, fit_);
    timings_.optimiser_ms = elapsed_ms(began);
}

bool RefinedTracker::start_from_tips(const StereoFrame& frame) {
    const auto found = recovery_.between_tips(frame);
    if (!found) return false;
    begin(*found);
    confirmed_ = false;  // what the images do not bear out was never found
    return true;
}

// The contrast of each part of the thread, so that something else is known as such.
void RefinedTracker::learn() {
    for (std::size_t eye = 0; eye < 2; ++eye)
        for (std::size_t j = 0; j < problem_.lines[eye].size(); ++j) {
            const LineMeasurement& m = problem_.lines[eye][j];
            double& depth = expected_depth_levels_[eye][j];
            if (m.kind != LineMeasurement::Kind::kSeen) continue;
            depth = depth > 0.0 ? 0.9 * depth + 0.1 * m.depth_levels : m.depth_levels;
        }
}

void RefinedTracker::conclude(const StereoFrame& frame) {
    const bool seen = !is_lost(fit_.quality, loss_test_);
    frames_unseen_ = seen ? 0 : frames_unseen_ + 1;
    status_ = seen ? scenes::TrackStatus::kTracking : scenes::TrackStatus::kCoasting;
    if (seen) learn();
    for (std::size_t end = 0; end < 2; ++end) {
        last_tips_C_[end].reset();
        if (frame.tips[end]) last_tips_C_[end] = frame.tips[end]->p_C;
    }
    capture_time_s_ = frame.capture_time_s;
    if (frames_unseen_ > config_.refined.coasting_frames) {
        started_ = false;
        lost(frame);
        return;
    }
    fill_estimate(frame);
}

// What the images say of the arms' constant errors.
void RefinedTracker::learn_ends(const StereoFrame& frame) {
    for (std::size_t end = 0; end < 2; ++end) {
        if (!frame.tips[end] || frame.tips[end]->kind == MeasuredTip::Kind::kFixed) continue;
        const int k = end == 0 ? 0 : config_.refined.control_points - 1;
        ends_[end].learn(frame.tips[end]->p_C, {fit_.Q.col(k), covariance_.block<3, 3>(3 * k, 3 * k)});
        if (grips_[end] && grips_[end]->excess_m)
            ends_[end].learn_excess(*grips_[end]->excess_m, grips_[end]->excess_sigma_m);
    }
}

void RefinedTracker::fill_estimate(const StereoFrame& frame) {
    double length_variance = 0.0;
    const bool determined =
        refinement_.covariance(problem_, fit_.Q, fit_.length_m, covariance_, length_variance);
    if (determined && status_ == scenes::TrackStatus::kTracking) learn_ends(frame);
    if (config_.thread.length_m <= 0.0 && determined && status_ == scenes::TrackStatus::kTracking) {
        expected_length_m_ = fit_.length_m;
        expected_length_sigma_m_ = std::max(std::sqrt(length_variance + 4e-10), 0.004 * fit_.length_m);
    }
    result_.frame = frame.index;
    result_.estimate.capture_time_s = frame.capture_time_s;
    result_.estimate.status = status_;
    result_.estimate.confidence = std::clamp(fit_.quality.worst_window, 0.0, 1.0);
    result_.support = fit_.quality.support;
    result_.control_points.resize(static_cast<std::size_t>(fit_.Q.cols()));
    for (int k = 0; k < fit_.Q.cols(); ++k)
        result_.control_points[static_cast<std::size_t>(k)] = fit_.Q.col(k);
    sample_with_uncertainty(refinement_.basis(), fit_.Q, covariance_, arc_, result_.estimate.samples);
}

const TrackResult& RefinedTracker::lost(const StereoFrame& frame) {
    status_ = scenes::TrackStatus::kLost;
    started_ = false;
    result_.frame = frame.index;
    result_.estimate.capture_time_s = frame.capture_time_s;
    result_.estimate.status = status_;
    result_.estimate.confidence = 0.0;
    result_.estimate.samples.clear();
    result_.control_points.clear();
    result_.support = 0.0;
    return result_;
}

void RefinedTracker::show(std::string_view stage, const Eigen::Matrix3Xd& Q) {
    if (!observer_) return;
    const std::vector<Eigen::Vector3d> points = curve_of(Q).control_points();
    observer_->curve(stage, points);
}

// method_state: length and its sigma, velocities, the last measured ends (flag and position) and what is
// believed of them, expected depths.
TrackerState RefinedTracker::state() const {
    TrackerState state;
    state.started = started_;
    state.status = status_;
    state.frames_unseen = frames_unseen_;
    state.capture_time_s = capture_time_s_;
    if (!started_) return state;
    state.control_points = curve_of(fit_.Q).control_points();
    std::vector<double>& out = state.method_state;
    out = {expected_length_m_, expected_length_sigma_m_};
    out.insert(out.end(), velocity_m_s_.data(), velocity_m_s_.data() + velocity_m_s_.size());
    for (const auto& tip : last_tips_C_) {
        const Eigen::Vector3d p_C = tip.value_or(Eigen::Vector3d::Zero());
        out.insert(out.end(), {tip ? 1.0 : 0.0, p_C.x(), p_C.y(), p_C.z()});
    }
    for (const EndBelief& end : ends_) {
        out.resize(out.size() + EndBelief::kStateSize);
        end.save(out.data() + out.size() - EndBelief::kStateSize);
    }
    for (const auto& depths : expected_depth_levels_) out.insert(out.end(), depths.begin(), depths.end());
    return state;
}

void RefinedTracker::restore(const TrackerState& state) {
    const std::size_t K = static_cast<std::size_t>(config_.refined.control_points);
    const std::size_t samples = static_cast<std::size_t>(config_.refined.samples);
    if (state.started && (state.control_points.size() != K ||
                          state.method_state.size() != 10 + 3 * K + 2 * EndBelief::kStateSize + 2 * samples))
        throw std::invalid_argument("a state of " + std::to_string(state.control_points.size()) +
                                    " control points, expected one of this tracker with " +
                                    std::to_string(K));
    started_ = confirmed_ = state.started;
    status_ = state.status;
    frames_unseen_ = state.frames_unseen;
    capture_time_s_ = state.capture_time_s;
    if (!started_) return;
    for (std::size_t k = 0; k < K; ++k) fit_.Q.col(static_cast<int>(k)) = state.control_points[k];
    auto in = state.method_state.begin();
    expected_length_m_ = *in++;
    expected_length_sigma_m_ = *in++;
    std::copy_n(in, velocity_m_s_.size(), velocity_m_s_.data());
    in += velocity_m_s_.size();
    for (auto& tip : last_tips_C_) {
        tip.reset();
        if (in[0] != 0.0) tip = Eigen::Vector3d(in[1], in[2], in[3]);
        in += 4;
    }
    for (EndBelief& end : ends_) {
        end.load(&*in);
        in += EndBelief::kStateSize;
    }
    for (auto& depths : expected_depth_levels_) {
        std::copy_n(in, depths.size(), depths.begin());
        in += static_cast<std::ptrdiff_t>(depths.size());
    }
}

}  // namespace atropos::tracker
