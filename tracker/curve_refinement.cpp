#include "tracker/curve_refinement.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
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

/// How much the curve's image bends, for one that is looked at along z.
double seen_bend(const CubicBasisValues& place, const Eigen::Matrix3Xd& Q) {
    const Eigen::Vector2d along = place.tangent(Q).head<2>().stableNormalized();
    const Eigen::Vector3d bend = place.bend(Q);
    return std::abs(along.x() * bend.y() - along.y() * bend.x());
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
      system_(control_points),
      step_(3 * control_points),
      trial_(3, control_points) {
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
                                                                    const Eigen::Matrix3Xd& Q) const {
    Eigen::Vector3d p = samples_[sample].point(Q);
    if (eye == 1) p = rig_.X_RC * p;
    if (p.z() < 1e-3) return std::nullopt;
    Eigen::Matrix<double, 2, 3> J_px;
    const Eigen::Vector2d px = (eye == 0 ? rig_.left : rig_.right).project(p, J_px);
    LineTerm term{line.normal.dot(px - line.point_px), line.normal.transpose() * J_px};
    if (eye == 1) term.by_point *= rig_.X_RC.linear();
    return term;
}

// Calls visit(line, sample, term) for every line that was seen; the number of those that have no term.
template <typename Visit>
int CurveRefinement::for_each_seen(const CurveProblem& problem, const Eigen::Matrix3Xd& Q,
                                   Visit&& visit) const {
    int behind = 0;
    for (std::size_t eye = 0; eye < 2; ++eye)
        for (std::size_t j = 0; j < samples_.size(); ++j) {
            const LineMeasurement& line = problem.lines[eye][j];
            if (line.kind != LineMeasurement::Kind::kSeen) continue;
            if (const std::optional<LineTerm> term = line_term(line, eye, j, Q))
                visit(line, samples_[j], *term);
            else
                ++behind;
        }
    return behind;
}

double CurveRefinement::add_lines(const CurveProblem& problem, const Eigen::Matrix3Xd& Q,
                                  bool normal_equations) {
    double cost = 0.0;
    const double c2 = problem.robust_px * problem.robust_px;
    const int behind = for_each_seen(
        problem, Q, [&](const LineMeasurement& line, const CubicBasisValues& sample, const LineTerm& term) {
            const double r2 = term.r_px * term.r_px;
            const double inverse_variance = 1.0 / (line.sigma_px * line.sigma_px);
            cost += 0.5 * c2 * inverse_variance * std::log1p(r2 / c2);
            if (normal_equations)
                system_.add(sample.first, by_control_points(sample.value, term.by_point), 0.0, term.r_px,
                            inverse_variance / (1.0 + r2 / c2));
        });
    return cost + kBehindCost * behind;
}

// N = H^-1 (sum of w J^T J) H^-1 at both ends: of the error H^-1 sum of w J^T r.
Matrix6d CurveRefinement::noise_of_ends(const CurveProblem& problem, const Eigen::Matrix3Xd& Q,
                                        const Eigen::MatrixXd& covariance) const {
    Matrix6d part = Matrix6d::Zero();
    const int last = 3 * (basis_.count() - 1);
    const double c2 = problem.robust_px * problem.robust_px;
    for_each_seen(
        problem, Q, [&](const LineMeasurement& line, const CubicBasisValues& sample, const LineTerm& term) {
            const Block J = by_control_points(sample.value, term.by_point);
            Vector6d moved;
            for (int i = 0; i < 6; ++i)
                moved[i] = covariance.row(i < 3 ? i : last + i - 3).segment<12>(3 * sample.first).dot(J);
            const double weight = 1.0 / (line.sigma_px * line.sigma_px * (1.0 + term.r_px * term.r_px / c2));
            part += weight * moved * moved.transpose();
        });
    return part;
}

// The gradient's change by the eye, H^-1 times its negative: lines of the right eye alone know of it.
Eigen::MatrixX2d CurveRefinement::by_eye(const CurveProblem& problem, const Eigen::Matrix3Xd& Q,
                                         const Eigen::MatrixXd& covariance) const {
    Eigen::MatrixX2d pull = Eigen::MatrixX2d::Zero(Q.size(), 2);
    const double c2 = problem.robust_px * problem.robust_px;
    for (std::size_t j = 0; j < samples_.size(); ++j) {
        const LineMeasurement& line = problem.lines[1][j];
        if (line.kind != LineMeasurement::Kind::kSeen) continue;
        const std::optional<LineTerm> term = line_term(line, 1, j, Q);
        if (!term) continue;
        const Eigen::Vector3d p = rig_.X_RC * samples_[j].point(Q);
        Eigen::Matrix<double, 2, 3> J_px;
        rig_.right.project(p, J_px);
        const Eigen::RowVector2d by_eye(line.normal.y(),
                                        line.normal.dot(J_px * Eigen::Vector3d(-p.y(), p.x(), 0.0)));
        const double weight = 1.0 / (line.sigma_px * line.sigma_px * (1.0 + term->r_px * term->r_px / c2));
        pull.middleRows<12>(3 * samples_[j].first) -=
            weight * by_control_points(samples_[j].value, term->by_point) * by_eye;
    }
    return covariance * pull;
}

double CurveRefinement::add_length(const CurveProblem& problem, const Eigen::Matrix3Xd& Q, double length_m,
                                   bool normal_equations) {
    const double weight = 1.0 / (priors_.stretch_sigma * priors_.stretch_sigma);
    double cost = 0.0;
    for (const CubicBasisValues& sample : samples_) {
        const Eigen::Vector3d tangent = sample.tangent(Q);
        const double speed = std::max(tangent.norm(), 1e-6);
        const double r = speed / length_m - 1.0;  // eq. 7
        cost += 0.5 * weight * r * r;
        if (normal_equations)
            system_.add(sample.first,
                        by_control_points(sample.derivative, tangent.transpose() / (speed * length_m)),
                        -speed / (length_m * length_m), r, weight);
    }
    const double r = length_m - problem.length_m;
    const double prior = 1.0 / (problem.length_sigma_m * problem.length_sigma_m);
    if (normal_equations) system_.add(0, Block::Zero(), 1.0, r, prior);
    return cost + 0.5 * prior * r * r;
}

// Depth is seen too badly to say how much the thread bends in it; a bend that travels along the thread comes
// from a neighbour.
double CurveRefinement::add_bending(const CurveProblem& problem, const Eigen::Matrix3Xd& Q, double length_m,
                                    bool normal_equations) {
    double cost = 0.0;
    const auto add = [&](const std::vector<CubicBasisValues>& places, double scale, double sigma, int usual) {
        // The prior is of the curve, not of its knots: fewer places weigh more.
        const double usual_weight = usual / static_cast<double>(places.size()) / (sigma * sigma);
        const double last = static_cast<double>(places.size()) - 1.0;
        seen_bends_.assign(places.size() + 2, 0.0);
        for (std::size_t i = 0; i < places.size() && problem.bent_as.cols() > 0; ++i)
            seen_bends_[i + 1] = scale * seen_bend(places[i], problem.bent_as);
        for (std::size_t i = 0; i < places.size(); ++i) {
            const CubicBasisValues& place = places[i];
            const double inside = std::min(static_cast<double>(i), last - static_cast<double>(i)) / last;
            const double soft = 1.0 + (priors_.clamp_factor - 1.0) *
                                          std::exp(-inside * problem.length_m / priors_.clamp_reach_m);
            const double weight = usual_weight / (soft * soft);
            const double bent = *std::max_element(seen_bends_.begin() + static_cast<std::ptrdiff_t>(i),
                                                  seen_bends_.begin() + static_cast<std::ptrdiff_t>(i + 3)) /
                                (sigma * soft);
            const double in_image = scale / std::sqrt(1.0 + bent * bent);
            const Eigen::Vector3d scales(in_image, in_image, scale);
            const Eigen::Vector3d r = scales.cwiseProduct(place.bend(Q));
            cost += 0.5 * weight * r.squaredNorm();
            if (!normal_equations) continue;
            for (int axis = 0; axis < 3; ++axis)
                system_.add(place.first,
                            by_control_points(place.second_derivative,
                                              scales[axis] * Eigen::Vector3d::Unit(axis).transpose()),
                            0.0, r[axis], weight);
        }
    };
    const double L2 = length_m * length_m;
    add(knots_, 1.0 / L2, priors_.curvature_sigma_per_m, 14);
    add(spans_, 1.0 / (L2 * length_m), priors_.curvature_change_sigma_per_m2, 13);
    return cost;
}

double CurveRefinement::add_point(int k, const Eigen::Vector3d& error, double weight, bool normal_equations) {
    if (normal_equations) {
        const int first = std::min(k, basis_.count() - 4);
        for (int axis = 0; axis < 3; ++axis) {
            Block J = Block::Zero();
            J[3 * (k - first) + axis] = 1.0;
            system_.add(first, J, 0.0, error[axis], weight);
        }
    }
    return 0.5 * weight * error.squaredNorm();
}

double CurveRefinement::add_end(int k, const EndPrior& prior, const Eigen::Matrix3Xd& Q,
                                bool normal_equations) {
    const Eigen::Vector3d error = Q.col(k) - prior.p_C;
    const double squared = prior.squared_error(Q.col(k));
    const double c2 = prior.robust_sigmas * prior.robust_sigmas;
    if (normal_equations) {
        const double weight = prior.weight(Q.col(k));
        const Eigen::Matrix3d rows = prior.information.llt().matrixU();
        const Eigen::Vector3d r = rows * error;
        const int first = std::min(k, basis_.count() - 4);
        for (int i = 0; i < 3; ++i) {
            Block J = Block::Zero();
            J.segment<3>(3 * (k - first)) = rows.row(i).transpose();
            system_.add(first, J, 0.0, r[i], weight);
        }
    }
    return c2 > 0.0 ? 0.5 * c2 * std::log1p(squared / c2) : 0.5 * squared;
}

double CurveRefinement::add_points(const CurveProblem& problem, const Eigen::Matrix3Xd& Q,
                                   bool normal_equations) {
    double cost = 0.0;
    for (std::size_t end = 0; end < 2; ++end)
        if (problem.ends[end])
            cost += add_end(end == 0 ? 0 : basis_.count() - 1, *problem.ends[end], Q, normal_equations);
    const double weight = 1.0 / (priors_.motion_sigma_m * priors_.motion_sigma_m);
    for (int k = 0; k < basis_.count(); ++k)
        cost += add_point(k, Q.col(k) - problem.expected.col(k), weight, normal_equations);
    return cost;
}

double CurveRefinement::accumulate(const CurveProblem& problem, const Eigen::Matrix3Xd& Q, double length_m,
                                   bool normal_equations) {
    if (normal_equations) system_.set_zero();
    return add_lines(problem, Q, normal_equations) + add_length(problem, Q, length_m, normal_equations) +
           add_bending(problem, Q, length_m, normal_equations) + add_points(problem, Q, normal_equations);
}

// The ends are left out: what is known of them says their own term.
double CurveRefinement::add_deformation(const CurveProblem& problem, const Eigen::Matrix3Xd& Q,
                                        bool normal_equations) {
    if (problem.deformation.empty()) return 0.0;
    offset_ = (Q - problem.expected).reshaped();
    offset_.head<3>().setZero();
    offset_.tail<3>().setZero();
    double information = 0.0;
    const double cost = problem.deformation.cost(offset_, unexplained_, information);
    if (normal_equations)
        for (int k = 1; k + 1 < basis_.count(); ++k)
            add_point(k, unexplained_.segment<3>(3 * k), information, true);
    return cost;
}

double CurveRefinement::cost(const CurveProblem& problem, const Eigen::Matrix3Xd& Q, double length_m,
                             bool normal_equations) {
    return accumulate(problem, Q, length_m, normal_equations) + add_deformation(problem, Q, normal_equations);
}

double CurveRefinement::refine(const CurveProblem& problem, int iterations, Eigen::Matrix3Xd& Q,
                               double& length_m) {
    double damping = 1e-6;
    double least = cost(problem, Q, length_m, true);
    for (int i = 0; i < iterations; ++i) {
        double length_step = 0.0;
        if (!system_.solve(damping, step_, length_step)) {
            damping = std::max(1e-3, damping * 10.0);
            continue;
        }
        trial_ = Q + step_.reshaped(3, basis_.count());
        const double trial_length_m = length_m + length_step;
        const bool sane = trial_length_m > 0.2 * length_m;
        const double trial_cost = sane ? cost(problem, trial_, trial_length_m, false) : 2.0 * least + 1.0;
        if (!(trial_cost <= least)) {
            damping = std::max(1e-3, damping * 10.0);
            continue;
        }
        const bool converged = step_.lpNorm<Eigen::Infinity>() < 1e-6;
        Q = trial_;
        length_m = trial_length_m;
        least = trial_cost;
        damping *= 0.1;
        if (converged) break;
        if (i + 1 < iterations) cost(problem, Q, length_m, true);
    }
    return least;
}

bool CurveRefinement::covariance(const CurveProblem& problem, const Eigen::Matrix3Xd& Q, double length_m,
                                 Eigen::MatrixXd& covariance, double& length_variance) {
    accumulate(problem, Q, length_m, true);
    return system_.covariance(covariance, length_variance);
}

}  // namespace atropos::tracker
