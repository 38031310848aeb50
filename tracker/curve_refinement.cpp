#include "tracker/curve_refinement.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace atropos::tracker {
namespace {

using Block = BorderedBandSystem::Block;

/// d (value . x) / d Q for a row vector by the point: the chain rule of a spline.
Block by_control_points(const std::array<double, 4>& weights, const Eigen::RowVector3d& by_point) {
    Block J;
    for (std::size_t i = 0; i < 4; ++i)
        J.segment<3>(static_cast<int>(3 * i)) = weights[i] * by_point.transpose();
    return J;
}

constexpr double kBehindCost = 1e6;  ///< of a point that is not before the camera
constexpr double kFixedTipSigma_m = 0.00005;

}  // namespace

EndPrior end_prior(const MeasuredTip& tip, double held_sigma_m) {
    const double sigma = tip.kind == MeasuredTip::Kind::kFixed ? kFixedTipSigma_m : held_sigma_m;
    return {tip.p_C, 1.0 / (sigma * sigma) * Eigen::Matrix3d::Identity(), 0.0};
}

CurveRefinement::CurveRefinement(int control_points, int samples, const CurvePriors& priors,
                                 const scenes::StereoRig& rig)
    : priors_(priors),
      rig_(rig),
      basis_(control_points),
      samples_(basis_.at_midpoints(samples)),
      system_(control_points, Nuisances::kCount),
      step_(3 * control_points),
      border_step_(static_cast<int>(Nuisances::kCount)),
      border_J_(Border::Zero(Nuisances::kCount)) {
    const std::vector<double> knots = basis_.basis().distinct_knots();
    for (double u : knots) knots_.push_back(basis_.at(u));
    for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
        const double width = knots[i + 1] - knots[i];
        CubicBasisValues span = basis_.at(knots[i] + 0.75 * width);
        const CubicBasisValues before = basis_.at(knots[i] + 0.25 * width);
        for (std::size_t a = 0; a < 4; ++a)
            span.second_derivative[a] =
                (span.second_derivative[a] - before.second_derivative[a]) / (0.5 * width);
        spans_.push_back(span);
    }
}

// Nothing for a point that is not before the camera.
std::optional<CurveRefinement::LineTerm> CurveRefinement::line_term(const LineMeasurement& line,
                                                                    std::size_t eye, std::size_t sample,
                                                                    const FittedCurve& fit,
                                                                    const scenes::StereoRig& rig) const {
    Eigen::Vector3d p = samples_[sample].point(fit.Q);
    if (eye == 1) p = rig.X_RC * p;
    if (p.z() < 1e-3) return std::nullopt;
    Eigen::Matrix<double, 2, 3> J_px;
    const Eigen::Vector2d px = (eye == 0 ? rig.left : rig.right).project(p, J_px);
    LineTerm term{line.normal.dot(px - line.point_px), line.normal.transpose() * J_px, {}};
    if (eye == 0) return term;
    term.by_eye = {line.normal.y(), term.by_point.dot(Eigen::Vector3d(-p.y(), p.x(), 0.0))};
    term.by_point *= rig.X_RC.linear();
    return term;
}

// Calls visit(line, sample, term) for every line that was seen; the number of those that have no term.
template <typename Visit>
int CurveRefinement::for_each_seen(const CurveProblem& problem, const FittedCurve& fit, Visit&& visit) const {
    const scenes::StereoRig rig = fit.nuisances.eye.applied_to(rig_);
    int behind = 0;
    for (std::size_t eye = 0; eye < 2; ++eye)
        for (std::size_t j = 0; j < samples_.size(); ++j) {
            const LineMeasurement& line = problem.lines[eye][j];
            if (line.kind != LineMeasurement::Kind::kSeen) continue;
            if (const std::optional<LineTerm> term = line_term(line, eye, j, fit, rig))
                visit(line, samples_[j], *term);
            else
                ++behind;
        }
    return behind;
}

double CurveRefinement::add_lines(const CurveProblem& problem, const FittedCurve& fit,
                                  bool normal_equations) {
    double cost = 0.0;
    const double c2 = problem.robust_px * problem.robust_px;
    const int behind = for_each_seen(
        problem, fit, [&](const LineMeasurement& line, const CubicBasisValues& sample, const LineTerm& term) {
            const double r2 = term.r_px * term.r_px;
            const double inverse_variance = 1.0 / (line.sigma_px * line.sigma_px);
            cost += 0.5 * c2 * inverse_variance * std::log1p(r2 / c2);
            if (!normal_equations) return;
            const Block J = by_control_points(sample.value, term.by_point);
            const double weight = inverse_variance / (1.0 + r2 / c2);
            border_J_.setZero();
            border_J_.segment<2>(Nuisances::kRow) << term.by_eye[0], term.by_eye[1];
            system_.add(sample.first, J, border_J_, term.r_px, weight);
        });
    return cost + kBehindCost * behind;
}

// N = H^-1 (sum of w J^T J) H^-1: of the error H^-1 sum of w J^T r. The arms' jitter is noise as well.
Nuisances::Matrix CurveRefinement::noise_part(const CurveProblem& problem, const FittedCurve& fit,
                                              const Covariance& covariance) const {
    Nuisances::Matrix part = Nuisances::Matrix::Zero();
    const double c2 = problem.robust_px * problem.robust_px;
    for_each_seen(
        problem, fit, [&](const LineMeasurement& line, const CubicBasisValues& sample, const LineTerm& term) {
            const double weight = 1.0 / (line.sigma_px * line.sigma_px * (1.0 + term.r_px * term.r_px / c2));
            const Nuisances::Vector moved = covariance.across.middleRows<12>(3 * sample.first).transpose() *
                                                by_control_points(sample.value, term.by_point) +
                                            covariance.border.middleCols<2>(Nuisances::kRow) *
                                                Eigen::Vector2d(term.by_eye[0], term.by_eye[1]);
            part += weight * moved * moved.transpose();
        });
    for (std::size_t end = 0; end < 2; ++end) {
        if (!problem.ends[end] || !problem.ends[end]->biased) continue;
        const Eigen::Matrix<double, 3, Nuisances::kCount> moved =
            covariance.across.middleRows<3>(end == 0 ? 0 : 3 * (basis_.count() - 1)) -
            covariance.border.middleRows<3>(Nuisances::tip(end));
        part += moved.transpose() * problem.ends[end]->information * moved;
    }
    return part;
}

double CurveRefinement::add_length(const FittedCurve& fit, bool normal_equations) {
    const double weight = 1.0 / (priors_.stretch_sigma * priors_.stretch_sigma);
    double cost = 0.0;
    const double length_m = fit.nuisances.length_m;
    border_J_.setZero();
    for (const CubicBasisValues& sample : samples_) {
        const Eigen::Vector3d tangent = sample.tangent(fit.Q);
        const double speed = std::max(tangent.norm(), 1e-6);
        const double r = speed / length_m - 1.0;  // eq. 7
        cost += 0.5 * weight * r * r;
        if (!normal_equations) continue;
        border_J_[Nuisances::kLength] = -speed / (length_m * length_m);
        system_.add(sample.first,
                    by_control_points(sample.derivative, tangent.transpose() / (speed * length_m)), border_J_,
                    r, weight);
    }
    return cost;
}

double CurveRefinement::add_nuisances(const CurveProblem& problem, const FittedCurve& fit,
                                      bool normal_equations) {
    const Nuisances::Vector error = fit.nuisances.vector() - problem.nuisances.mean.vector();
    if (normal_equations) system_.add_border(problem.nuisances.information, error);
    return 0.5 * error.dot(problem.nuisances.information * error);
}

double CurveRefinement::add_bending(const FittedCurve& fit, double expected_length_m, bool normal_equations) {
    double cost = 0.0;
    const auto add = [&](const std::vector<CubicBasisValues>& places, double scale, double sigma, int usual) {
        // The prior is of the curve, not of its knots: fewer places weigh more.
        const double usual_weight = usual / static_cast<double>(places.size()) / (sigma * sigma);
        const double last = static_cast<double>(places.size()) - 1.0;
        for (std::size_t i = 0; i < places.size(); ++i) {
            const CubicBasisValues& place = places[i];
            const double inside = std::min(static_cast<double>(i), last - static_cast<double>(i)) / last;
            const double soft = 1.0 + (priors_.clamp_factor - 1.0) *
                                          std::exp(-inside * expected_length_m / priors_.clamp_reach_m);
            const double weight = usual_weight / (soft * soft);
            const Eigen::Vector3d r = scale * place.bend(fit.Q);
            cost += 0.5 * weight * r.squaredNorm();
            if (!normal_equations) continue;
            for (int axis = 0; axis < 3; ++axis)
                system_.add(place.first,
                            by_control_points(place.second_derivative,
                                              scale * Eigen::Vector3d::Unit(axis).transpose()),
                            r[axis], weight);
        }
    };
    const double L2 = fit.nuisances.length_m * fit.nuisances.length_m;
    add(knots_, 1.0 / L2, priors_.curvature_sigma_per_m, 14);
    add(spans_, 1.0 / (L2 * fit.nuisances.length_m), priors_.curvature_change_sigma_per_m2, 13);
    return cost;
}

double CurveRefinement::add_point(int k, const Eigen::Vector3d& error, double weight, bool normal_equations) {
    if (normal_equations) {
        const int first = std::min(k, basis_.count() - 4);
        for (int axis = 0; axis < 3; ++axis) {
            Block J = Block::Zero();
            J[3 * (k - first) + axis] = 1.0;
            system_.add(first, J, error[axis], weight);
        }
    }
    return 0.5 * weight * error.squaredNorm();
}

double CurveRefinement::add_end(std::size_t end, const EndPrior& prior, const FittedCurve& fit,
                                bool normal_equations) {
    const int k = end == 0 ? 0 : basis_.count() - 1, first = std::min(k, basis_.count() - 4);
    Eigen::Vector3d error = fit.Q.col(k) - prior.p_C;
    if (prior.biased) error -= fit.nuisances.tip_bias_C[end];
    const double squared = error.dot(prior.information * error);
    const double c2 = prior.robust_sigmas * prior.robust_sigmas;
    if (normal_equations) {
        const double weight = c2 > 0.0 ? 1.0 / (1.0 + squared / c2) : 1.0;
        const Eigen::Matrix3d rows = prior.information.llt().matrixU();
        const Eigen::Vector3d r = rows * error;
        border_J_.setZero();
        for (int i = 0; i < 3; ++i) {
            Block J = Block::Zero();
            J.segment<3>(3 * (k - first)) = rows.row(i).transpose();
            if (prior.biased) border_J_.segment<3>(Nuisances::tip(end)) = -rows.row(i).transpose();
            system_.add(first, J, border_J_, r[i], weight);
        }
    }
    return c2 > 0.0 ? 0.5 * c2 * std::log1p(squared / c2) : 0.5 * squared;
}

double CurveRefinement::add_grip(std::size_t end, const GripPrior& prior, const FittedCurve& fit,
                                 bool normal_equations) {
    const int k = end == 0 ? 0 : basis_.count() - 1, first = std::min(k, basis_.count() - 4);
    const double r = prior.along.dot(fit.Q.col(k) - prior.p_C) / prior.sigma_m;
    if (normal_equations) {
        Block J = Block::Zero();
        J.segment<3>(3 * (k - first)) = prior.along / prior.sigma_m;
        system_.add(first, J, r, 1.0);
    }
    return 0.5 * r * r;
}

double CurveRefinement::add_points(const CurveProblem& problem, const FittedCurve& fit,
                                   bool normal_equations) {
    double cost = 0.0;
    for (std::size_t end = 0; end < 2; ++end) {
        if (problem.ends[end]) cost += add_end(end, *problem.ends[end], fit, normal_equations);
        if (problem.grips[end]) cost += add_grip(end, *problem.grips[end], fit, normal_equations);
    }
    const double weight = 1.0 / (priors_.motion_sigma_m * priors_.motion_sigma_m);
    for (int k = 0; k < basis_.count(); ++k)
        cost += add_point(k, fit.Q.col(k) - problem.expected.col(k), weight, normal_equations);
    return cost;
}

double CurveRefinement::accumulate(const CurveProblem& problem, const FittedCurve& fit,
                                   bool normal_equations) {
    if (normal_equations) system_.set_zero();
    return add_lines(problem, fit, normal_equations) + add_length(fit, normal_equations) +
           add_nuisances(problem, fit, normal_equations) +
           add_bending(fit, problem.nuisances.mean.length_m, normal_equations) +
           add_points(problem, fit, normal_equations);
}

double CurveRefinement::refine(const CurveProblem& problem, int iterations, FittedCurve& fit) {
    double damping = 1e-6;
    double cost = accumulate(problem, fit, true);
    for (int i = 0; i < iterations; ++i) {
        if (!system_.solve(damping, step_, border_step_)) {
            damping = std::max(1e-3, damping * 10.0);
            continue;
        }
        trial_.Q = fit.Q + step_.reshaped(3, basis_.count());
        trial_.nuisances = Nuisances::from(fit.nuisances.vector() + border_step_);
        const bool sane = trial_.nuisances.length_m > 0.2 * fit.nuisances.length_m;
        const double trial_cost = sane ? accumulate(problem, trial_, false) : 2.0 * cost + 1.0;
        if (!(trial_cost <= cost)) {
            damping = std::max(1e-3, damping * 10.0);
            continue;
        }
        const bool converged = step_.lpNorm<Eigen::Infinity>() < 1e-6;
        fit = trial_;
        cost = trial_cost;
        damping *= 0.1;
        if (converged) break;
        if (i + 1 < iterations) accumulate(problem, fit, true);
    }
    return cost;
}

bool CurveRefinement::covariance(const CurveProblem& problem, const FittedCurve& fit, Covariance& out) {
    accumulate(problem, fit, true);
    return system_.covariance(out);
}

}  // namespace atropos::tracker
