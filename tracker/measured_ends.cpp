#include "tracker/measured_ends.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace atropos::tracker {
namespace {

constexpr double kRobustSigmas = 6.0;
constexpr double kUnknown = 1e-6;  ///< of the information along the thread: what is known across it

EndBelief::Options belief_options(const scenes::TrackerConfig& config) {
    return {.bias_sigma_m = config.refined.tip_bias_sigma_m, .jitter_sigma_m = config.refined.tip_sigma_m};
}

EndPrior prior_of(const UncertainPoint& expected) {
    return {expected.p_C, expected.covariance.inverse(), kRobustSigmas};
}

bool is_held(const std::optional<MeasuredTip>& tip) {
    return tip && tip->kind == MeasuredTip::Kind::kHeld;
}

/// What is known of an end that no arm holds: a knot, or what the finder saw, which may be gone astray.
EndPrior unheld_prior(const MeasuredTip& tip) {
    constexpr double kSeenSigma_m = 0.0003, kSeenRobustSigmas = 3.0;
    if (tip.kind == MeasuredTip::Kind::kFixed) return end_prior(tip, 0.0);
    EndPrior prior = end_prior(tip, kSeenSigma_m);
    prior.robust_sigmas = kSeenRobustSigmas;
    return prior;
}

}  // namespace

MeasuredEnds::MeasuredEnds(const scenes::TrackerConfig& config, const scenes::StereoRig& rig,
                           const ValleyFilterOptions& filter)
    : beliefs_{EndBelief(belief_options(config)), EndBelief(belief_options(config))},
      grip_sight_(rig, filter, config.thread.width_m) {}

void MeasuredEnds::reset() {
    for (EndBelief& belief : beliefs_) belief.reset();
}

std::array<Eigen::Vector3d, 2> MeasuredEnds::motion(const StereoFrame& frame) const {
    std::array<Eigen::Vector3d, 2> moved = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    for (std::size_t end = 0; end < 2; ++end)
        if (frame.tips[end] && last_tips_C_[end]) moved[end] = frame.tips[end]->p_C - *last_tips_C_[end];
    return moved;
}

void MeasuredEnds::wait(double dt_s) {
    for (EndBelief& belief : beliefs_) belief.wait(dt_s);
}

void MeasuredEnds::place(const StereoFrame& frame, std::vector<scenes::Capsule>& instruments_C) const {
    instruments_C = frame.instruments;
    for (std::size_t end = 0; end < 2; ++end) {
        if (!is_held(frame.tips[end])) continue;
        for (std::size_t i = 0; i < instruments_C.size(); ++i) {
            if (scenes::clearance_m(frame.instruments[i], frame.tips[end]->p_C) > GripSight::kSameArm_m)
                continue;
            instruments_C[i].a += beliefs_[end].bias_C();
            instruments_C[i].b += beliefs_[end].bias_C();
        }
    }
}

void MeasuredEnds::expect(const StereoFrame& frame, CurveProblem& problem) {
    for (std::size_t end = 0; end < 2; ++end) {
        grips_[end].reset();
        problem.ends[end].reset();
        if (!frame.tips[end]) continue;
        if (!is_held(frame.tips[end])) {
            problem.ends[end] = unheld_prior(*frame.tips[end]);
            continue;
        }
        expected_[end] = beliefs_[end].expected(frame.tips[end]->p_C);
        problem.ends[end] = prior_of(expected_[end]);
    }
}

void MeasuredEnds::look(const StereoFrame& frame, const std::array<ImageView, 2>& images,
                        const CubicBasis& basis, const Eigen::Matrix3Xd& Q, double length_m,
                        CurveProblem& problem) {
    expect(frame, problem);
    for (std::size_t end = 0; end < 2; ++end) {
        if (frame.tips[end] && !is_held(frame.tips[end])) continue;
        const int last = static_cast<int>(Q.cols()) - 1, k = end == 0 ? 0 : last;
        const Eigen::Vector3d outwards = (Q.col(k) - Q.col(end == 0 ? 1 : k - 1)).normalized();
        if (!frame.tips[end]) {
            const auto free_end = grip_sight_.look_free(images, basis, Q, length_m, end, frame.instruments);
            if (!free_end) continue;
            const double sharpness = 1.0 / (free_end->sigma_m * free_end->sigma_m);
            problem.ends[end] = {Q.col(k) + free_end->offset_m * outwards,
                                 sharpness * outwards * outwards.transpose() +
                                     kUnknown * sharpness * Eigen::Matrix3d::Identity()};
            continue;
        }
        const UncertainPoint& expected = expected_[end];
        GripQuery query;
        query.end = end;
        query.measured_C = frame.tips[end]->p_C;
        query.instruments_C = frame.instruments;
        query.expected_m = outwards.dot(expected.p_C - Q.col(k));
        query.sigma_m = std::sqrt(outwards.dot(expected.covariance * outwards));
        query.excess_m = beliefs_[end].excess_m();
        query.excess_variance_m2 = beliefs_[end].excess_variance_m2();
        grips_[end] = grip_sight_.look(images, basis, Q, length_m, query);
        if (!grips_[end]) continue;
        EndPrior& prior = *problem.ends[end];
        const Eigen::Vector3d seen_C = Q.col(k) + grips_[end]->offset_m * outwards;
        const Eigen::Matrix3d along =
            outwards * outwards.transpose() / (grips_[end]->sigma_m * grips_[end]->sigma_m);
        const Eigen::Matrix3d both = prior.information + along;
        prior.p_C = both.inverse() * (prior.information * prior.p_C + along * seen_C);
        prior.information = both;
    }
}

void MeasuredEnds::learn(const StereoFrame& frame, const CurveProblem& problem,
                         const CurveRefinement& refinement, const Eigen::Matrix3Xd& Q,
                         const Eigen::MatrixXd& covariance) {
    const Eigen::Index last = 3 * (Q.cols() - 1);
    FittedEnds fit;
    fit.p_C << Q.leftCols<1>(), Q.rightCols<1>();
    fit.covariance << covariance.block<3, 3>(0, 0), covariance.block<3, 3>(0, last),
        covariance.block<3, 3>(last, 0), covariance.block<3, 3>(last, last);
    fit.by_noise = refinement.noise_of_ends(problem, Q, covariance);
    std::array<ToldEnd, 2> told, unlearned;
    for (std::size_t end = 0; end < 2; ++end) {
        if (!is_held(frame.tips[end])) continue;
        const EndPrior prior = prior_of(expected_[end]);
        told[end] = {prior.p_C, prior.weight(fit.end(end).p_C) * prior.information};
        const UncertainPoint at_first = beliefs_[end].unlearned(frame.tips[end]->p_C);
        unlearned[end] = {at_first.p_C, at_first.covariance.inverse()};
    }
    for (std::size_t end = 0; end < 2; ++end) {
        if (!is_held(frame.tips[end])) continue;
        const FittedEnds alone = told_instead(fit, 1 - end, told[1 - end], unlearned[1 - end]);
        beliefs_[end].learn(
            end_evidence(told[end].p_C, told[end].information, alone.end(end), alone.noise(end)));
        if (grips_[end] && grips_[end]->excess_m)
            beliefs_[end].learn_excess(*grips_[end]->excess_m, grips_[end]->excess_sigma_m);
    }
}

double MeasuredEnds::farthest_m(const StereoFrame& frame, const Eigen::Matrix3Xd& Q) {
    double farthest = 0.0;
    for (std::size_t end = 0; end < 2; ++end)
        if (is_held(frame.tips[end]))
            farthest = std::max(farthest, (frame.tips[end]->p_C - Q.col(end == 0 ? 0 : Q.cols() - 1)).norm());
    return farthest;
}

void MeasuredEnds::remember(const StereoFrame& frame) {
    for (std::size_t end = 0; end < 2; ++end) {
        last_tips_C_[end].reset();
        if (frame.tips[end]) last_tips_C_[end] = frame.tips[end]->p_C;
    }
}

// Of each end whether it was measured last, where, and what is believed of it.
void MeasuredEnds::save(double* out) const {
    for (std::size_t end = 0; end < 2; ++end) {
        const Eigen::Vector3d p_C = last_tips_C_[end].value_or(Eigen::Vector3d::Zero());
        *out++ = last_tips_C_[end] ? 1.0 : 0.0;
        out = std::copy_n(p_C.data(), 3, out);
        beliefs_[end].save(out);
        out += EndBelief::kStateSize;
    }
}

void MeasuredEnds::load(const double* in) {
    for (std::size_t end = 0; end < 2; ++end) {
        last_tips_C_[end].reset();
        if (in[0] != 0.0) last_tips_C_[end] = Eigen::Vector3d(in[1], in[2], in[3]);
        beliefs_[end].load(in + 4);
        in += 4 + EndBelief::kStateSize;
    }
}

}  // namespace atropos::tracker
