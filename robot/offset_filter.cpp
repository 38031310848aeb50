#include "robot/offset_filter.hpp"

#include <Eigen/LU>
#include <cmath>

namespace atropos::robot {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d ray_covariance(const Vector3d& p_C, double sigma_lateral_m, double sigma_depth_m) {
    const Vector3d ray = p_C.normalized();
    const double lateral = sigma_lateral_m * sigma_lateral_m, depth = sigma_depth_m * sigma_depth_m;
    return lateral * Matrix3d::Identity() + (depth - lateral) * ray * ray.transpose();
}

OffsetFilter::OffsetFilter(const Options& options)
    : options_(options), P_(options.prior_sigma_m * options.prior_sigma_m * Matrix3d::Identity()) {}

void OffsetFilter::travel(double way_m, double dt_s) {
    const double keep = std::exp(-(way_m + options_.creep_m_s * dt_s) / options_.forget_m);
    offset_ *= keep;
    P_ *= keep * keep;
    P_.diagonal().array() += (1.0 - keep * keep) * options_.prior_sigma_m * options_.prior_sigma_m;
}

bool OffsetFilter::update(const InstrumentOffset& measured, const Vector3d& p_C) {
    if (!measured.offset_C_m.allFinite() || !(measured.sigma_lateral_m > 0.0) ||
        !(measured.sigma_depth_m > 0.0))
        return false;
    const Matrix3d R = ray_covariance(p_C, measured.sigma_lateral_m, measured.sigma_depth_m);
    const Matrix3d S_inverse = (P_ + R).inverse();
    const Vector3d innovation = measured.offset_C_m - offset_;
    if (innovation.dot(S_inverse * innovation) > options_.max_surprise) return false;
    const Matrix3d K = P_ * S_inverse, I_K = Matrix3d::Identity() - K;
    offset_ += K * innovation;
    P_ = (I_K * P_ * I_K.transpose() + K * R * K.transpose()).eval();
    return true;
}

Matrix3d OffsetFilter::covariance(const Vector3d& p_C) const {
    return P_ + ray_covariance(p_C, options_.floor_lateral_m, options_.floor_depth_m);
}

}  // namespace atropos::robot
