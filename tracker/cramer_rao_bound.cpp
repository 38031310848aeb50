#include "tracker/cramer_rao_bound.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tracker/curve_refinement.hpp"
#include "tracker/occlusion_mask.hpp"

namespace atropos::tracker {
namespace {

constexpr int kSamples = 80;

/// Standard deviation (px) of the offset across one px of the thread's image.
double offset_sigma_px(double width_px, const BoundOptions& o) {
    const double s2 = o.blur_px * o.blur_px + 1.0 / 12.0;
    const double information = o.contrast_levels * o.contrast_levels / std::sqrt(std::numbers::pi * s2) *
                               (1.0 - std::exp(-width_px * width_px / (4.0 * s2)));
    return o.noise_levels / std::sqrt(information);
}

void measure_ideally(const CurveRefinement& fit, const Eigen::Matrix3Xd& Q, const scenes::StereoRig& rig,
                     std::size_t eye, const OcclusionMask& mask, const BoundOptions& options,
                     std::vector<LineMeasurement>& lines) {
    const scenes::Camera& camera = eye == 0 ? rig.left : rig.right;
    const Eigen::Isometry3d X_EC = eye == 0 ? Eigen::Isometry3d::Identity() : rig.X_RC;
    lines.resize(kSamples);
    for (std::size_t j = 0; j < lines.size(); ++j) {
        const Eigen::Vector3d p_C = fit.samples()[j].point(Q);
        const Eigen::Vector3d p = X_EC * p_C;
        if (p.z() < 0.005 || mask.hides(p_C)) continue;
        Eigen::Matrix<double, 2, 3> J_px;
        lines[j].point_px = camera.project(p, J_px);
        const Eigen::Vector2d along = J_px * X_EC.linear() * fit.samples()[j].tangent(Q);
        if (!camera.contains(lines[j].point_px) || along.norm() < 1e-6) continue;
        lines[j].kind = LineMeasurement::Kind::kSeen;
        lines[j].normal = Eigen::Vector2d(-along.y(), along.x()).normalized();
        lines[j].sigma_px = offset_sigma_px(options.width_m * camera.fx_px / p.z(), options) /
                            std::sqrt(along.norm() / kSamples);
    }
}

/// Mean length of a normal vector in the plane with covariance eigenvalues a >= b.
double mean_length(double a, double b) {
    if (!(a > 0.0)) return 0.0;
    const double k = std::sqrt(std::max(0.0, 1.0 - std::max(0.0, b) / a));
    return std::sqrt(2.0 * a / std::numbers::pi) * std::comp_ellint_2(k);
}

}  // namespace

Bound cramer_rao_bound(const scenes::Polyline& truth_C, const scenes::StereoRig& rig,
                       std::span<const scenes::Capsule> instruments_C, const BoundOptions& options) {
    const int K = options.control_points;
    const CurvePriors priors{.stretch_sigma = options.stretch_sigma,
                             .curvature_sigma_per_m = 1e4,
                             .curvature_change_sigma_per_m2 = 1e8,
                             .motion_sigma_m = 1.0};
    CurveRefinement fit(K, kSamples, priors, rig);
    const NurbsCurve curve = fit_curve(truth_C, {.control_points = K, .length_weight = 0.3});
    Eigen::Matrix3Xd Q(3, K);
    for (int k = 0; k < K; ++k) Q.col(k) = curve.control_points()[static_cast<std::size_t>(k)];

    CurveProblem problem;
    problem.expected = Q;
    problem.length_m = truth_C.length_m();
    problem.length_sigma_m = options.length_sigma_m;
    problem.ends = {end_prior({Q.col(0)}, options.tip_sigma_m),
                    end_prior({Q.col(K - 1)}, options.tip_sigma_m)};
    const OcclusionMask left(instruments_C, Eigen::Vector3d::Zero(), 0.0, 0.0);
    const OcclusionMask right(instruments_C, rig.X_RC.inverse().translation(), 0.0, 0.0);
    measure_ideally(fit, Q, rig, 0, left, options, problem.lines[0]);
    measure_ideally(fit, Q, rig, 1, right, options, problem.lines[1]);

    Eigen::MatrixXd covariance(3 * K, 3 * K);
    double length_variance = 0.0;
    if (!fit.covariance(problem, Q, problem.length_m, covariance, length_variance))
        throw std::runtime_error("the curve is not determined by images and priors, expected one that is");
    Bound bound;
    for (const CubicBasisValues& place : fit.samples()) {
        Eigen::Matrix3d cov = Eigen::Matrix3d::Zero();
        for (int a = 0; a < 4; ++a)
            for (int b = 0; b < 4; ++b)
                cov += place.value[static_cast<std::size_t>(a)] * place.value[static_cast<std::size_t>(b)] *
                       covariance.block<3, 3>(3 * (place.first + a), 3 * (place.first + b));
        const Eigen::Vector3d tangent = place.tangent(Q).normalized();
        const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - tangent * tangent.transpose();
        const Eigen::Vector3d eigen =
            Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(across * cov * across).eigenvalues();
        bound.mean_3d_m += mean_length(eigen[2], eigen[1]) / kSamples;
    }
    return bound;
}

}  // namespace atropos::tracker
