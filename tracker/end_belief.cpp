#include "tracker/end_belief.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace atropos::tracker {
namespace {

/// What the mean of many frames still is off by: errors of the images that do not change.
constexpr double kFloor_m = 0.00015;
constexpr double kExcessFloor_m = 0.0001;

constexpr double kUseless_m = 0.02;  ///< evidence that is worse than this says nothing
constexpr double kResolution_m = 1e-6;

/// Chi-square of three at 99 %: constant errors do not leap, wrongly seen ends do.
constexpr double kGate = 11.3;

Eigen::Matrix3d clamped_below_zero(const Eigen::Matrix3d& A) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(0.5 * (A + A.transpose()));
    return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
           eigen.eigenvectors().transpose();
}

}  // namespace

UncertainPoint FittedEnds::end(std::size_t which) const {
    const Eigen::Index i = 3 * static_cast<Eigen::Index>(which);
    return {p_C.segment<3>(i), covariance.block<3, 3>(i, i)};
}

Eigen::Matrix3d FittedEnds::noise(std::size_t which) const {
    const Eigen::Index i = 3 * static_cast<Eigen::Index>(which);
    return by_noise.block<3, 3>(i, i);
}

// Offsets from where the fit has the ends. A pull of noise moves them by the covariance times it: N = S V S,
// with the same V.
FittedEnds told_instead(const FittedEnds& fit, std::size_t which, const ToldEnd& told,
                        const ToldEnd& instead) {
    const Eigen::Index i = 3 * static_cast<Eigen::Index>(which);
    const Eigen::Vector3d p = fit.p_C.segment<3>(i);
    const Matrix6d before = fit.covariance.inverse();
    Matrix6d information = before;
    information.block<3, 3>(i, i) += instead.information - told.information;
    Vector6d pull = Vector6d::Zero();
    pull.segment<3>(i) = instead.information * (instead.p_C - p) - told.information * (told.p_C - p);
    FittedEnds other;
    other.covariance = information.inverse();
    other.p_C = fit.p_C + other.covariance * pull;
    const Matrix6d moved = other.covariance * before;
    other.by_noise = moved * fit.by_noise * moved.transpose();
    return other;
}

// With H' all of the fit but the end's own prior, H = H' + S^-1 at the end: the marginal information of H' at
// the end is M = Sigma^-1 - S^-1, and M N' M = Sigma^-1 N Sigma^-1 for the noise's share N of the covariance.
EndEvidence end_evidence(const Eigen::Vector3d& expected_C, const Eigen::Matrix3d& told,
                         const UncertainPoint& fitted, const Eigen::Matrix3d& by_noise) {
    const Eigen::Matrix3d inverse = fitted.covariance.inverse();
    EndEvidence evidence;
    evidence.information = clamped_below_zero(inverse - told);
    evidence.new_part = inverse * by_noise * inverse;
    evidence.score = inverse * (fitted.p_C - expected_C);
    return evidence;
}

EndBelief::EndBelief(const Options& options) : options_(options) {
    reset();
}

void EndBelief::reset() {
    bias_C_.setZero();
    common_.setZero();
    P_.setIdentity();
    P_.topLeftCorner<3, 3>() *= options_.bias_sigma_m * options_.bias_sigma_m;
    excess_m_ = 0.0;
    excess_variance_m2_ = options_.excess_sigma_m * options_.excess_sigma_m;
}

void EndBelief::wait(double dt_s) {
    const double keep = std::exp(-dt_s / options_.forget_s);
    const double forgotten = 1.0 - keep * keep;
    bias_C_ *= keep;
    common_ *= keep;
    P_ *= keep * keep;
    P_.diagonal().head<3>().array() += forgotten * options_.bias_sigma_m * options_.bias_sigma_m;
    P_.diagonal().tail<3>().array() += forgotten;
}

UncertainPoint EndBelief::expected(const Eigen::Vector3d& measured_C) const {
    const double floor = std::min(kFloor_m, options_.bias_sigma_m);
    const double jitter = options_.jitter_sigma_m;
    return {measured_C + bias_C_,
            P_.topLeftCorner<3, 3>() + (jitter * jitter + floor * floor) * Eigen::Matrix3d::Identity()};
}

UncertainPoint EndBelief::unlearned(const Eigen::Vector3d& measured_C) const {
    return EndBelief(options_).expected(measured_C);
}

// The evidence places the end M_r^-1 score from where it was expected: H (bias + jitter + C^1/2 common) and
// noise, H = M_r^-1 M. What bounds M_r from below keeps directions that nobody looks along out of it.
void EndBelief::learn(const EndEvidence& evidence) {
    const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
    const double least = 1.0 / (kUseless_m * kUseless_m);
    const Eigen::Matrix3d M_inverse = (evidence.information + least * I).inverse();
    const Eigen::Matrix3d H = M_inverse * evidence.information;
    const Eigen::Matrix3d common_covariance =
        M_inverse * clamped_below_zero(evidence.information - evidence.new_part + least * I) * M_inverse +
        kFloor_m * kFloor_m * I;
    const Eigen::Matrix3d noise =
        M_inverse * evidence.new_part * M_inverse + kResolution_m * kResolution_m * I;
    const double jitter = options_.jitter_sigma_m;

    Eigen::Matrix<double, 3, 6> by_state;
    by_state.leftCols<3>() = H;
    by_state.rightCols<3>() =
        H * Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(common_covariance).operatorSqrt();
    const Eigen::Matrix3d innovation_covariance =
        by_state * P_ * by_state.transpose() + jitter * jitter * H * H.transpose() + noise;
    const Eigen::Matrix3d weight = innovation_covariance.inverse();
    // Where the end was expected holds the bias already.
    const Eigen::Vector3d innovation = M_inverse * evidence.score - by_state.rightCols<3>() * common_;
    if (innovation.dot(weight * innovation) > kGate) return;
    const Eigen::Matrix<double, 6, 3> gain = P_ * by_state.transpose() * weight;
    const Eigen::Matrix<double, 6, 1> step = gain * innovation;
    bias_C_ += step.head<3>();
    common_ += step.tail<3>();
    P_ -= gain * innovation_covariance * gain.transpose();
    P_ = 0.5 * (P_ + P_.transpose()).eval();
}

void EndBelief::learn_excess(double seen_m, double sigma_m) {
    const double gain = excess_variance_m2_ / (excess_variance_m2_ + sigma_m * sigma_m);
    excess_m_ += gain * (seen_m - excess_m_);
    excess_variance_m2_ = std::max((1.0 - gain) * excess_variance_m2_, kExcessFloor_m * kExcessFloor_m);
}

void EndBelief::save(double* out) const {
    out = std::copy_n(bias_C_.data(), 3, out);
    out = std::copy_n(common_.data(), 3, out);
    out = std::copy_n(P_.data(), 36, out);
    *out++ = excess_m_;
    *out = excess_variance_m2_;
}

void EndBelief::load(const double* in) {
    std::copy_n(in, 3, bias_C_.data());
    std::copy_n(in + 3, 3, common_.data());
    std::copy_n(in + 6, 36, P_.data());
    excess_m_ = in[42];
    excess_variance_m2_ = in[43];
}

}  // namespace atropos::tracker
