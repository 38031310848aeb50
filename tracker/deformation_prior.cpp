#include "tracker/deformation_prior.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace atropos::tracker {
namespace {

// Frames one after another err alike: displacements between them are smaller than what the last one is off
// by.
constexpr double kTrust = 0.1;
constexpr double kFreedom = 4.0;            ///< of the multivariate t
constexpr double kStraight = 0.01;          ///< sag over chord below which a curve has no side
constexpr double kOrthonormal = 1e-6;       ///< of the modes' products
constexpr double kLeastTime_s = 1.0 / 240;  ///< a frame repeated is no frame without motion

}  // namespace

void validate(const DeformationPrior& prior) {
    const auto require = [](bool holds, const std::string& what) {
        if (!holds) throw std::invalid_argument(what);
    };
    require(prior.control_points >= 4 && prior.control_points <= 64,
            "modes of " + std::to_string(prior.control_points) + " control points, expected 4 to 64");
    require(prior.frame_rate_hz >= 0.1 && prior.frame_rate_hz <= 10000.0,
            "a frame rate of " + std::to_string(prior.frame_rate_hz) + " Hz, expected 0.1 to 10000");
    const long M = prior.sigmas_m.size();
    require(M >= 1 && M < 3 * prior.control_points, std::to_string(M) + " modes, expected 1 to 3K - 1");
    require(prior.modes.rows() == 3 * prior.control_points && prior.modes.cols() == M,
            "modes of " + std::to_string(prior.modes.rows()) + " numbers, expected three for each of " +
                std::to_string(prior.control_points) + " control points");
    require(prior.modes.allFinite() && (prior.modes.transpose() * prior.modes).isIdentity(kOrthonormal),
            "modes that are not orthonormal, expected those that were learned");
    for (long m = 0; m < M; ++m)
        require(prior.sigmas_m[m] > 0.0 && prior.sigmas_m[m] < 1.0 &&
                    (m == 0 || prior.sigmas_m[m] <= prior.sigmas_m[m - 1]),
                "a mode's sigma of " + std::to_string(1e3 * prior.sigmas_m[m]) +
                    " mm, expected falling ones between 0 and 1000");
    require(prior.rest_sigma_m > 0.0 && prior.rest_sigma_m <= prior.sigmas_m[M - 1],
            "a rest sigma of " + std::to_string(1e3 * prior.rest_sigma_m) +
                " mm, expected more than 0 and no more than the last mode's");
}

Eigen::Matrix3d thread_frame(const Eigen::Matrix3Xd& Q) {
    const Eigen::Vector3d first = Q.col(0), chord = Q.rightCols<1>() - first;
    const double length = chord.norm();
    Eigen::Matrix3d axes;
    axes.col(0) = length > 1e-9 ? Eigen::Vector3d(chord / length) : Eigen::Vector3d::UnitX();
    const auto across = [&](const Eigen::Vector3d& v) {
        return (v - axes.col(0).dot(v) * axes.col(0)).eval();
    };
    Eigen::Vector3d side = across(Q.rowwise().mean() - first);
    if (!(side.norm() > kStraight * length)) side = across(Eigen::Vector3d::UnitZ());
    if (!(side.norm() > 1e-9)) side = axes.col(0).unitOrthogonal();
    axes.col(1) = side.normalized();
    axes.col(2) = axes.col(0).cross(axes.col(1));
    return axes;
}

DeformationModes placed(const DeformationPrior& prior, const Eigen::Matrix3Xd& Q, double dt_s) {
    DeformationModes modes;
    const Eigen::Matrix3d axes_C = thread_frame(Q);
    const double scale = std::max(dt_s, kLeastTime_s) * prior.frame_rate_hz;
    modes.V.resize(prior.modes.rows(), prior.modes.cols());
    for (long m = 0; m < prior.modes.cols(); ++m)
        for (long k = 0; k < Q.cols(); ++k)
            modes.V.col(m).segment<3>(3 * k).noalias() = axes_C * prior.modes.col(m).segment<3>(3 * k);
    modes.sigmas_m = scale * prior.sigmas_m;
    modes.rest_sigma_m = scale * prior.rest_sigma_m;
    modes.weight = kTrust;
    return modes;
}

Eigen::VectorXd DeformationModes::amplitudes(const Eigen::VectorXd& offset) const {
    const Eigen::ArrayXd variances = sigmas_m.array().square();
    return variances / (variances + rest_sigma_m * rest_sigma_m) * (V.transpose() * offset).array();
}

double DeformationModes::cost(const Eigen::VectorXd& offset, Eigen::VectorXd& shrunk,
                              double& information) const {
    const Eigen::VectorXd a = amplitudes(offset);
    shrunk = offset - V * a;
    const double rest = 1.0 / (rest_sigma_m * rest_sigma_m);
    const double squared = rest * shrunk.squaredNorm() + (a.array() / sigmas_m.array()).square().sum();
    const double n = static_cast<double>(offset.size());
    information = weight * rest * (kFreedom + n) / (kFreedom + squared);
    return weight * 0.5 * (kFreedom + n) * std::log1p(squared / kFreedom);
}

}  // namespace atropos::tracker
