#include "tracker/refined_tracker.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "tracker/curve_uncertainty.hpp"

namespace atropos::tracker {
namespace {

constexpr double kLeastSearch_px = 3.0;     ///< about a prediction that is right; at 640
constexpr double kSearchPerSurprise = 2.0;  ///< more of it for each px that predictions were off by lately
constexpr double kSurpriseKept = 0.7;       ///< from one frame to the next
constexpr double kSettled_px = 2.0;         ///< a curve that moves by more tells nothing of the arms yet
constexpr int kRetryFrames = 4;             ///< between searches for a thread that is not seen
constexpr double kLeastSlide_m = 0.0001;    ///< Newton's steps follow a bend so far by themselves
constexpr int kMoreControlPoints = 8;
constexpr double kMostlySeen = 0.6;       ///< support of a curve that is right but for a stretch
constexpr double kLeastEndOff_m = 0.004;  ///< no end is lost that is nearer to where it was measured

int first_control_points(const scenes::TrackerConfig& config, const std::optional<DeformationPrior>& prior) {
    if (config.refined.control_points > 0) return config.refined.control_points;
    return prior ? prior->control_points : needed_control_points(config.thread.length_m);
}

constexpr double kRollPerRow = 0.0035;    ///< sigma of the roll for a sigma of one row at 640
constexpr double kDoubtSigmas = 3.0;      ///< a length further off is compared with a free one
constexpr double kRefutedSigmas = 4.0;    ///< and refuted by that
constexpr double kWrongLength = 0.1;      ///< sigma of lengths that are given wrongly, share of it
constexpr double kLengthWanders = 0.002;  ///< sigma from frame to frame of one that is not given, share of it

double elapsed_ms(std::chrono::steady_clock::time_point since) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - since).count();
}

void check_prior(const DeformationPrior& prior, int control_points) {
    validate(prior);
    if (prior.control_points != control_points)
        throw std::invalid_argument(
            "a learned prior of " + std::to_string(prior.control_points) +
            " control points, expected refined.K = " + std::to_string(control_points));
}

}  // namespace

RefinedTracker::RefinedTracker(const scenes::TrackerConfig& config, const scenes::StereoRig& rig)
    : RefinedTracker(config, rig, CurvePriors{}) {}

RefinedTracker::RefinedTracker(const scenes::TrackerConfig& config, const scenes::StereoRig& rig,
                               const CurvePriors& priors, std::optional<DeformationPrior> deformation)
    : config_(config),
      given_rig_(rig),
      rig_(rig),
      scale_(rig.left.width_px / 640.0),
      priors_(priors),
      refinement_(first_control_points(config, deformation), config.refined.samples, priors, rig),
      interpolation_(refinement_.basis()),
      sight_(config, rig),
      ends_(config, rig, sight_.filter_options()),
      recovery_(config, rig),
      deformation_(std::move(deformation)) {
    validate(config);
    if (config.refined.prior_weight == 0.0) deformation_.reset();
    if (deformation_) check_prior(*deformation_, refinement_.basis().count());
    if (config.refined.rod) rod_.emplace(refinement_.basis(), config.refined.gravity_C);
    const std::size_t samples = static_cast<std::size_t>(config.refined.samples);
    loss_test_.residual_px *= scale_;
    loss_test_.end_off_m = std::max(
        kLeastEndOff_m, 5.0 * std::hypot(config.refined.tip_bias_sigma_m, config.refined.tip_sigma_m));
    if (config.refined.row_sigma_px > 0.0)
        eye_.emplace(EyeSight::Options{.row_sigma_px = config.refined.row_sigma_px,
                                       .roll_sigma_rad = kRollPerRow * config.refined.row_sigma_px},
                     rig);
    const int K = refinement_.basis().count();
    fit_.Q.setZero(3, K);
    problem_.expected.setZero(3, K);
    motion_.velocity_m_s.setZero(3, K);
    covariance_.setZero(3 * K, 3 * K);
    for (auto& lines : problem_.lines) lines.resize(samples);
}

RefinedTracker::~RefinedTracker() = default;

const TrackResult& RefinedTracker::start(const StereoFrame& frame, const NurbsCurve& initial) {
    check_frame(frame, rig_);
    ends_.reset();
    length_refuted_ = false;
    if (eye_) eye_->reset();
    begin(initial);
    return track(frame);
}

// The curves carried from frame to frame become ones of K control points.
void RefinedTracker::set_control_points(int K) {
    const CubicBasis before = refinement_.basis();
    if (K == before.count()) return;
    refinement_ = CurveRefinement(K, config_.refined.samples, priors_, rig_);
    interpolation_ = CurveInterpolation(refinement_.basis());
    for (Eigen::Matrix3Xd* Q :
         {&fit_.Q, &motion_.velocity_m_s, &expected_, &problem_.expected, &problem_.bent_as})
        if (Q->cols() == before.count()) *Q = interpolation_.carried_over(before, *Q);
    covariance_.setZero(3 * K, 3 * K);
    if (rod_) rod_.emplace(refinement_.basis(), config_.refined.gravity_C);
}

/// What was learned of deformation was so for one number of them.
bool RefinedTracker::chooses_control_points() const {
    return config_.refined.control_points == 0 && !deformation_;
}

bool RefinedTracker::has_too_few_control_points() const {
    const int K = refinement_.basis().count();
    return chooses_control_points() && 2 * (K + kMoreControlPoints) <= config_.refined.samples &&
           needed_control_points(refinement_.basis(), fit_.Q, fit_.length_m) > K;
}

void RefinedTracker::begin(const NurbsCurve& initial) {
    if (chooses_control_points()) set_control_points(needed_control_points(initial.length()));
    fit_.Q = control_points_of(initial);
    fit_.length_m = initial.length();
    while (has_too_few_control_points()) {
        set_control_points(refinement_.basis().count() + kMoreControlPoints);
        fit_.Q = control_points_of(initial);
    }
    const bool known = takes_given_length();
    expected_length_m_ = known ? config_.thread.length_m : initial.length();
    expected_length_sigma_m_ = known ? config_.refined.length_sigma_m : 0.03 * expected_length_m_;
    fit_.length_m = expected_length_m_;
    motion_.velocity_m_s.setZero();
    surprise_px_ = config_.refined.search_px;
    ends_.forget_motion();
    sight_.reset();
    started_ = confirmed_ = true;
    status_ = scenes::TrackStatus::kTracking;
    frames_unseen_ = 0;
    capture_time_s_ = -1.0;
}

// The cameras of this frame: what the right eye was found to be off by, with what this frame says of it.
void RefinedTracker::correct_eye(const StereoFrame& frame) {
    const bool first = capture_time_s_ < 0.0;
    eye_->look(images_, first ? 0.0 : std::clamp(frame.capture_time_s - capture_time_s_, 0.0, 1.0));
    set_rig(eye_->found().correction.applied_to(given_rig_));
}

void RefinedTracker::set_rig(const scenes::StereoRig& rig) {
    rig_ = rig;
    refinement_.set_rig(rig);
    sight_.set_rig(rig);
    ends_.set_rig(rig);
}

// The ends' measured motion is free of their constant error.
void RefinedTracker::predict(const StereoFrame& frame) {
    const double dt =
        capture_time_s_ < 0.0 ? 0.0 : std::clamp(frame.capture_time_s - capture_time_s_, 0.0, 1.0);
    motion_.predict(fit_.Q, ends_.motion(frame), dt, problem_.expected);
    problem_.deformation = {};
    if (capture_time_s_ >= 0.0) {
        if (rod_)
            rod_->correct(fit_.Q, {frame.tips[0].has_value(), frame.tips[1].has_value()}, dt,
                          problem_.expected);
        if (deformation_) problem_.deformation = placed(*deformation_, fit_.Q, dt * (1 + frames_unseen_));
        problem_.deformation.weight *= config_.refined.prior_weight;
    }
    ends_.wait(dt);
    ends_.place(frame, instruments_C_);
    problem_.length_m = expected_length_m_;
    problem_.length_sigma_m = expected_length_sigma_m_;
}

void RefinedTracker::refine(const StereoFrame& frame, double first_search_px, Fit& fit) {
    const auto share = [&](double most) {
        return std::min(first_search_px, most * config_.refined.search_px);
    };
    const Round rounds[] = {{{first_search_px, 1.0, false}, 2.0, 3},
                            {{share(0.6), 0.8, false}, 1.0, 2},
                            {{share(0.33), 0.5, false}, 0.5, 2},
                            {{share(0.25), 0.3, true}, 0.5, 2}};
    ends_.expect(frame, problem_);
    for (const Round& round : rounds) {
        if (round.look.closely)
            ends_.look(frame, images_, refinement_.basis(), fit.Q, fit.length_m, problem_);
        slide_to_ends(fit);
        sight_.look(images_, refinement_.samples(), fit.Q, instruments_C_, round.look, problem_.lines);
        problem_.robust_px = round.robust_px * scale_;
        refinement_.refine(problem_, round.iterations, fit.Q, fit.length_m);
    }
    fit.quality = judge_fit(problem_.lines, refinement_.samples(), fit.Q, fit.length_m, rig_, loss_test_);
    fit.quality.end_off_m = ends_.farthest_m(frame, fit.Q);
}

void RefinedTracker::slide_to_ends(Fit& fit) const {
    const double wanted_m = wanted_slide_m(problem_.ends, fit.Q);
    if (std::abs(wanted_m) < kLeastSlide_m) return;
    fit.Q = interpolation_.carried_over(refinement_.basis(), fit.Q, wanted_m / fit.length_m);
}

// A curve that turns by more than its spans can follow is fitted again, with more of them.
void RefinedTracker::follow_bends(const StereoFrame& frame) {
    while (!is_lost(fit_.quality, loss_test_) && has_too_few_control_points()) {
        set_control_points(refinement_.basis().count() + kMoreControlPoints);
        refine(frame, 0.25 * config_.refined.search_px, fit_);
    }
}

// As far about the prediction as predictions were wrong lately: what lies farther off is another line.
// Farther only when nothing is found there.
void RefinedTracker::look_near_expected(const StereoFrame& frame) {
    const double widest_px = config_.refined.search_px;
    const double search_px = kLeastSearch_px + kSearchPerSurprise * surprise_px_;
    for (const double within_px : {std::min(search_px, widest_px), widest_px}) {
        fit_.Q = expected_;
        fit_.length_m = problem_.length_m;
        refine(frame, within_px, fit_);
        if (!is_lost(fit_.quality, loss_test_) || within_px == widest_px) return;
    }
}

// A length that is given may be wrong. A curve that has just begun tells: later the arms' learned errors have
// made up for it. What the first fit says of the length beside the prior, if far enough from it, is compared
// with a fit that is free to choose.
void RefinedTracker::doubt_length(const StereoFrame& frame) {
    if (is_lost(fit_.quality, loss_test_) || std::abs(length_surprise()) <= kDoubtSigmas) return;
    const double given_m = expected_length_m_, sigma_m = expected_length_sigma_m_;
    expected_length_sigma_m_ = kWrongLength * given_m;
    problem_.length_sigma_m = expected_length_sigma_m_;
    look_near_expected(frame);
    length_refuted_ = !is_lost(fit_.quality, loss_test_) && std::abs(length_surprise()) > kRefutedSigmas;
    if (length_refuted_) return;
    expected_length_sigma_m_ = problem_.length_sigma_m = sigma_m;
    look_near_expected(frame);
}

// Of what the fit says apart from what it was told, in sigmas: M = 1 / variance - 1 / sigma^2.
double RefinedTracker::length_surprise() {
    double variance = 0.0;
    if (!refinement_.covariance(problem_, fit_.Q, fit_.length_m, covariance_, variance)) return 0.0;
    const double told = 1.0 / (problem_.length_sigma_m * problem_.length_sigma_m);
    const double information = 1.0 / variance - told;
    if (!(information > 0.0)) return 0.0;
    const double off_m = (fit_.length_m - problem_.length_m) / (information * variance);
    const double given_sigma_m = config_.refined.length_sigma_m;
    return off_m / std::sqrt(1.0 / information + given_sigma_m * given_sigma_m);
}

// How far off the thread was across the prediction's images, at most; px at 640.
double RefinedTracker::surprise_px() const {
    double most = 0.0;
    for (std::size_t eye = 0; eye < 2; ++eye) {
        const scenes::Camera& camera = eye == 0 ? rig_.left : rig_.right;
        for (std::size_t j = 0; j < refinement_.samples().size(); ++j) {
            const LineMeasurement& line = problem_.lines[eye][j];
            if (line.kind != LineMeasurement::Kind::kSeen) continue;
            Eigen::Vector3d p = refinement_.samples()[j].point(expected_);
            if (eye == 1) p = rig_.X_RC * p;
            most = std::max(most, std::abs(line.normal.dot(camera.project(p) - line.point_px)));
        }
    }
    return most / scale_;
}

const TrackResult& RefinedTracker::track(const StereoFrame& frame) {
    const auto began = std::chrono::steady_clock::now();
    timings_ = {};
    check_frame(frame, rig_);
    if (!started_ && !start_from_tips(frame)) return lost(frame);
    images_[0] = channel_view(frame.left, config_.thread.channel, buffers_[0]);
    images_[1] = channel_view(frame.right, config_.thread.channel, buffers_[1]);
    const bool first = capture_time_s_ < 0.0;
    if (eye_) correct_eye(frame);
    predict(frame);
    show("before", problem_.expected);
    expected_ = problem_.bent_as = problem_.expected;
    look_near_expected(frame);
    follow_bends(frame);
    // An end that is neither measured nor seen slides along the thread.
    if (first && takes_given_length() && problem_.ends[0] && problem_.ends[1]) doubt_length(frame);
    timings_.refinement_ms = elapsed_ms(began);
    if (is_lost(fit_.quality, loss_test_) && config_.refined.recovery) recover(frame);

    if (!confirmed_ && (is_lost(fit_.quality, loss_test_) || fit_.quality.support < kMostlySeen))
        return lost(frame);
    confirmed_ = true;

    const double dt = capture_time_s_ < 0.0 ? 0.0 : frame.capture_time_s - capture_time_s_;
    if (dt > 0.0) motion_.follow(fit_.Q, expected_, dt);
    show("refined", fit_.Q);
    conclude(frame);
    timings_.total_ms = elapsed_ms(began);
    return result_;
}

Eigen::Matrix3Xd RefinedTracker::control_points_of(const NurbsCurve& curve) const {
    const int K = refinement_.basis().count();
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
    problem_.deformation = {};  // what was searched for is no prediction
    refine(frame, 0.6 * config_.refined.search_px, other_);
    if (!is_lost(other_.quality, loss_test_) && other_.quality.score() > best.quality.score())
        std::swap(best, other_);
    else
        std::swap(problem_, chosen_problem_);
}

// About the prediction, and between the measured ends; searched again only after some frames, since what did
// not find the thread in one frame hardly finds it in the next.
void RefinedTracker::recover(const StereoFrame& frame) {
    const auto began = std::chrono::steady_clock::now();
    const Eigen::Matrix3Xd expected = problem_.expected;
    const int turn = frames_unseen_ % (2 * kRetryFrames);
    // A curve that is right but for a stretch waits: its own next frame is the better search.
    const bool mostly_seen = fit_.quality.support >= kMostlySeen &&
                             fit_.quality.rms_stretch <= loss_test_.rms_stretch &&
                             fit_.quality.end_off_m <= loss_test_.end_off_m;
    if (turn == 0 && (frames_unseen_ > 0 || !mostly_seen))
        if (const auto found = near(frame, expected)) try_fit(frame, *found, fit_);
    if (turn == kRetryFrames) {
        const bool hangs = frames_unseen_ % (4 * kRetryFrames) == kRetryFrames;
        if (const auto found = hangs ? recovery_.between_tips(frame) : recovery_.traced(frame))
            try_fit(frame, *found, fit_);
    }
    timings_.optimiser_ms = elapsed_ms(began);
}

std::optional<NurbsCurve> RefinedTracker::near(const StereoFrame& frame, const Eigen::Matrix3Xd& expected) {
    if (problem_.deformation.empty()) return recovery_.near(frame, curve_of(expected));
    return recovery_.along_modes(frame, expected, expected_length_m_, problem_.deformation);
}

// A thread that lies in loops is none that hangs between its ends: traced, every other time.
bool RefinedTracker::start_from_tips(const StereoFrame& frame) {
    if (frames_unseen_ % kRetryFrames != 0) return false;
    const bool hangs = frames_unseen_ % (2 * kRetryFrames) == 0;
    const auto found = hangs ? recovery_.between_tips(frame) : recovery_.traced(frame);
    if (!found) return false;
    const int unseen = frames_unseen_;
    begin(*found);
    frames_unseen_ = unseen;
    confirmed_ = false;  // what the images do not bear out was never found
    return true;
}

void RefinedTracker::conclude(const StereoFrame& frame) {
    const bool seen = !is_lost(fit_.quality, loss_test_);
    frames_unseen_ = seen ? 0 : frames_unseen_ + 1;
    status_ = seen ? scenes::TrackStatus::kTracking : scenes::TrackStatus::kCoasting;
    surprise_px_ = seen ? std::max(surprise_px(), kSurpriseKept * surprise_px_) : config_.refined.search_px;
    if (seen) sight_.learn(problem_.lines);
    ends_.remember(frame);
    capture_time_s_ = frame.capture_time_s;
    if (frames_unseen_ > config_.refined.coasting_frames) {
        lost(frame);
        return;
    }
    fill_estimate(frame);
}

void RefinedTracker::fill_estimate(const StereoFrame& frame) {
    double length_variance = 0.0;
    const bool determined =
        refinement_.covariance(problem_, fit_.Q, fit_.length_m, covariance_, length_variance);
    if (determined && status_ == scenes::TrackStatus::kTracking) {
        if (surprise_px_ < kSettled_px) ends_.learn(frame, problem_, refinement_, fit_.Q, covariance_);
        if (!takes_given_length()) {
            expected_length_m_ = fit_.length_m;
            expected_length_sigma_m_ =
                std::max(std::sqrt(length_variance + 4e-10), kLengthWanders * fit_.length_m);
        }
    }
    result_.frame = frame.index;
    result_.estimate.capture_time_s = frame.capture_time_s;
    result_.estimate.status = status_;
    result_.estimate.confidence = std::clamp(fit_.quality.worst_window, 0.0, 1.0);
    result_.support = fit_.quality.support;
    result_.control_points.resize(static_cast<std::size_t>(fit_.Q.cols()));
    for (int k = 0; k < fit_.Q.cols(); ++k)
        result_.control_points[static_cast<std::size_t>(k)] = fit_.Q.col(k);
    result_.eye.reset();
    if (eye_) {
        result_.eye = eye_->found();
        const Eigen::MatrixX2d moved = refinement_.by_eye(problem_, fit_.Q, covariance_);
        covariance_ += moved * result_.eye->covariance * moved.transpose();
    }
    result_.length_refuted = length_refuted_;
    sample_with_uncertainty(refinement_.basis(), fit_.Q, covariance_, arc_, result_.estimate.samples);
}

const TrackResult& RefinedTracker::lost(const StereoFrame& frame) {
    status_ = scenes::TrackStatus::kLost;
    started_ = false;
    ++frames_unseen_;
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

}  // namespace atropos::tracker
