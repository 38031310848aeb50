#include "tracker/end_belief.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace atropos::tracker {
namespace {

/// What the mean of many frames still is off by: errors of the images that do not change.
constexpr double kFloor_m = 0.00015;
constexpr double kCommonSigma_m = 0.0005;
constexpr double kExcessFloor_m = 0.0001;

}  // namespace

EndBelief::EndBelief(const Options& options) : options_(options) {
    reset();
}

void EndBelief::reset() {
    bias_C_.setZero();
    P_ = options_.bias_sigma_m * options_.bias_sigma_m * Eigen::Matrix3d::Identity();
    excess_m_ = 0.0;
    excess_variance_m2_ = options_.excess_sigma_m * options_.excess_sigma_m;
}

void EndBelief::wait(double dt_s) {
    const double keep = std::exp(-dt_s / options_.forget_s);
    const double prior = options_.bias_sigma_m * options_.bias_sigma_m;
    bias_C_ *= keep;
    P_ = keep * keep * P_ + (1.0 - keep * keep) * prior * Eigen::Matrix3d::Identity();
}

UncertainPoint EndBelief::expected(const Eigen::Vector3d& measured_C) const {
    const double floor = std::min(kFloor_m, options_.bias_sigma_m);
    const double jitter = options_.jitter_sigma_m;
    return {measured_C + bias_C_, P_ + (jitter * jitter + floor * floor) * Eigen::Matrix3d::Identity()};
}

void EndBelief::learn(const Eigen::Vector3d& measured_C, const UncertainPoint& fitted) {
    // The images alone measured the end with covariance R, (S + R)^-1 = S^-1 (S - fitted) S^-1; what
    // successive frames have in common is added to R.
    const UncertainPoint before = expected(measured_C);
    const Eigen::Matrix3d S_inverse = before.covariance.inverse();
    const Eigen::Matrix3d M = S_inverse * (before.covariance - fitted.covariance) * S_inverse;
    const Eigen::Matrix3d share =
        (Eigen::Matrix3d::Identity() + kCommonSigma_m * kCommonSigma_m * M).inverse();
    bias_C_ += P_ * share * S_inverse * (fitted.p_C - before.p_C);
    P_ -= P_ * share * M * P_;
    P_ = 0.5 * (P_ + P_.transpose()).eval();
}

void EndBelief::learn_excess(double seen_m, double sigma_m) {
    const double gain = excess_variance_m2_ / (excess_variance_m2_ + sigma_m * sigma_m);
    excess_m_ += gain * (seen_m - excess_m_);
    excess_variance_m2_ = std::max((1.0 - gain) * excess_variance_m2_, kExcessFloor_m * kExcessFloor_m);
}

void EndBelief::save(double* out) const {
    out = std::copy_n(bias_C_.data(), 3, out);
    out = std::copy_n(P_.data(), 9, out);
    *out++ = excess_m_;
    *out = excess_variance_m2_;
}

void EndBelief::load(const double* in) {
    std::copy_n(in, 3, bias_C_.data());
    std::copy_n(in + 3, 9, P_.data());
    excess_m_ = in[12];
    excess_variance_m2_ = in[13];
}

}  // namespace atropos::tracker
