#include "tracker/measured_ends.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace atropos::tracker {
namespace {

constexpr double kRobustSigmas = 3.0;
constexpr double kExcessFloor_m = 0.0001;

bool is_held(const std::optional<MeasuredTip>& tip) {
    return tip && tip->kind != MeasuredTip::Kind::kFixed;
}

}  // namespace

MeasuredEnds::MeasuredEnds(const scenes::TrackerConfig& config, const ValleyFilterOptions& filter)
    : jitter_sigma_m_(config.refined.tip_sigma_m), grip_sight_(filter, config.thread.width_m) {}

std::array<Eigen::Vector3d, 2> MeasuredEnds::motion(const StereoFrame& frame) const {
    std::array<Eigen::Vector3d, 2> moved = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    for (std::size_t end = 0; end < 2; ++end)
        if (frame.tips[end] && last_tips_C_[end]) moved[end] = frame.tips[end]->p_C - *last_tips_C_[end];
    return moved;
}

void MeasuredEnds::place(const StereoFrame& frame, const Nuisances& expected,
                         std::vector<scenes::Capsule>& instruments_C) {
    instruments_C = frame.instruments;
    for (std::size_t end = 0; end < 2; ++end) {
        if (!is_held(frame.tips[end])) continue;
        for (std::size_t i = 0; i < instruments_C.size(); ++i) {
            if (scenes::clearance_m(frame.instruments[i], frame.tips[end]->p_C) > GripSight::kSameArm_m)
                continue;
            instruments_C[i].a += expected.tip_bias_C[end];
            instruments_C[i].b += expected.tip_bias_C[end];
        }
    }
}

void MeasuredEnds::expect(const StereoFrame& frame, CurveProblem& problem) const {
    problem.grips = {};
    for (std::size_t end = 0; end < 2; ++end) {
        problem.ends[end].reset();
        if (!frame.tips[end]) continue;
        problem.ends[end] = end_prior(*frame.tips[end], jitter_sigma_m_);
        if (!is_held(frame.tips[end])) continue;
        problem.ends[end]->robust_sigmas = kRobustSigmas;
        problem.ends[end]->biased = true;
    }
}

void MeasuredEnds::look(const StereoFrame& frame, const scenes::StereoRig& rig,
                        const std::array<ImageView, 2>& images, const CubicBasis& basis,
                        const FittedCurve& fit, const Nuisances::Matrix& covariance, CurveProblem& problem) {
    seen_ = {};
    const Eigen::Matrix3Xd& Q = fit.Q;
    for (std::size_t end = 0; end < 2; ++end) {
        if (frame.tips[end] && !is_held(frame.tips[end])) continue;
        const int last = static_cast<int>(Q.cols()) - 1, k = end == 0 ? 0 : last;
        const int tip = Nuisances::tip(end);
        const Eigen::Vector3d outwards = (Q.col(k) - Q.col(end == 0 ? 1 : k - 1)).normalized();
        if (!frame.tips[end]) {
            const auto free_end =
                grip_sight_.look_free(rig, images, basis, Q, fit.nuisances.length_m, end, frame.instruments);
            if (free_end)
                problem.grips[end] = {Q.col(k) + free_end->offset_m * outwards, outwards, free_end->sigma_m};
            continue;
        }
        const Eigen::Vector3d expected_C = frame.tips[end]->p_C + problem.nuisances.mean.tip_bias_C[end];
        GripQuery query;
        query.end = end;
        query.measured_C = frame.tips[end]->p_C;
        query.instruments_C = frame.instruments;
        query.expected_m = outwards.dot(expected_C - Q.col(k));
        query.sigma_m = std::sqrt(outwards.dot(covariance.block<3, 3>(tip, tip) * outwards) +
                                  jitter_sigma_m_ * jitter_sigma_m_);
        query.excess_m = jaws_[end].m;
        query.excess_variance_m2 = jaws_[end].variance_m2;
        seen_[end] = grip_sight_.look(rig, images, basis, Q, fit.nuisances.length_m, query);
        if (seen_[end])
            problem.grips[end] = {Q.col(k) + seen_[end]->offset_m * outwards, outwards, seen_[end]->sigma_m};
    }
}

void MeasuredEnds::learn() {
    for (std::size_t end = 0; end < 2; ++end) {
        if (!seen_[end] || !seen_[end]->excess_m) continue;
        JawExcess& jaws = jaws_[end];
        const double noise_m2 = seen_[end]->excess_sigma_m * seen_[end]->excess_sigma_m;
        const double gain = jaws.variance_m2 / (jaws.variance_m2 + noise_m2);
        jaws.m += gain * (*seen_[end]->excess_m - jaws.m);
        jaws.variance_m2 = std::max((1.0 - gain) * jaws.variance_m2, kExcessFloor_m * kExcessFloor_m);
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

// Of each end whether it was measured last, where, and how its jaws look.
void MeasuredEnds::save(double* out) const {
    for (std::size_t end = 0; end < 2; ++end) {
        const Eigen::Vector3d p_C = last_tips_C_[end].value_or(Eigen::Vector3d::Zero());
        *out++ = last_tips_C_[end] ? 1.0 : 0.0;
        out = std::copy_n(p_C.data(), 3, out);
        *out++ = jaws_[end].m;
        *out++ = jaws_[end].variance_m2;
    }
}

void MeasuredEnds::load(const double* in) {
    for (std::size_t end = 0; end < 2; ++end) {
        last_tips_C_[end].reset();
        if (in[0] != 0.0) last_tips_C_[end] = Eigen::Vector3d(in[1], in[2], in[3]);
        jaws_[end] = {in[4], in[5]};
        in += 6;
    }
}

}  // namespace atropos::tracker
