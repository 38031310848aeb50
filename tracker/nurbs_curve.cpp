#include "tracker/nurbs_curve.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace atropos::tracker {
namespace {

constexpr std::array<double, 8> kGaussNodes = {0.0950125098376374, 0.2816035507792589, 0.4580167776572274,
                                               0.6178762444026438, 0.7554044083550030, 0.8656312023878318,
                                               0.9445750230732326, 0.9894009349916499};
constexpr std::array<double, 8> kGaussWeights = {0.1894506104550685, 0.1826034150449236, 0.1691565193950025,
                                                 0.1495959888165767, 0.1246289712555339, 0.0951585116824928,
                                                 0.0622535239386479, 0.0271524594117541};

double binomial(int n, int k) {
    double value = 1.0;
    for (int i = 1; i <= k; ++i) value = value * (n - k + i) / i;
    return value;
}

}  // namespace

template <int Dim>
BasicNurbsCurve<Dim>::BasicNurbsCurve(int degree, std::vector<Point> control_points)
    : basis_(degree, static_cast<int>(control_points.size())),
      control_points_(std::move(control_points)),
      weights_(control_points_.size(), 1.0) {}

template <int Dim>
BasicNurbsCurve<Dim>::BasicNurbsCurve(BsplineBasis basis, std::vector<Point> control_points,
                                      std::vector<double> weights)
    : basis_(std::move(basis)), control_points_(std::move(control_points)), weights_(std::move(weights)) {
    const std::size_t count = static_cast<std::size_t>(basis_.count());
    if (control_points_.size() != count || weights_.size() != count)
        throw std::invalid_argument(std::to_string(control_points_.size()) + " control points and " +
                                    std::to_string(weights_.size()) + " weights, expected " +
                                    std::to_string(count) + " of each");
    if (std::find(weights_.begin(), weights_.end(), 0.0) != weights_.end())
        throw std::invalid_argument("a weight of 0, expected another value");
}

template <int Dim>
void BasicNurbsCurve<Dim>::set_control_points(const std::vector<Point>& control_points) {
    if (control_points.size() != control_points_.size())
        throw std::invalid_argument(std::to_string(control_points.size()) + " control points, expected " +
                                    std::to_string(control_points_.size()));
    control_points_ = control_points;
}

template <int Dim>
Eigen::VectorXd BasicNurbsCurve<Dim>::rational_basis(double u) const {
    Eigen::VectorXd values = basis_.row(u);
    for (int k = 0; k < values.size(); ++k) values[k] *= weights_[static_cast<std::size_t>(k)];
    return values / values.sum();
}

template <int Dim>
typename BasicNurbsCurve<Dim>::Point BasicNurbsCurve<Dim>::point(double u) const {
    return derivative(u, 0);
}

template <int Dim>
typename BasicNurbsCurve<Dim>::Point BasicNurbsCurve<Dim>::derivative(double u, int order) const {
    const Eigen::MatrixXd N = basis_.derivatives(u, order);
    const int first = basis_.span(u) - degree();
    std::vector<Point> A(static_cast<std::size_t>(order + 1), Point::Zero());  // numerator's derivatives
    std::vector<double> w(static_cast<std::size_t>(order + 1), 0.0);           // denominator's
    for (std::size_t n = 0; n < A.size(); ++n) {
        for (int k = 0; k <= degree(); ++k) {
            const std::size_t i = static_cast<std::size_t>(first + k);
            const double factor = N(static_cast<int>(n), k) * weights_[i];
            A[n] += factor * control_points_[i];
            w[n] += factor;
        }
    }
    std::vector<Point> C(A.size());
    for (std::size_t n = 0; n < A.size(); ++n) {
        C[n] = A[n];
        for (std::size_t i = 1; i <= n; ++i)
            C[n] -= binomial(static_cast<int>(n), static_cast<int>(i)) * w[i] * C[n - i];
        C[n] /= w[0];
    }
    return C.back();
}

template <int Dim>
double BasicNurbsCurve<Dim>::length(double from, double to) const {
    double total = 0.0;
    const std::vector<double> knots = basis_.distinct_knots();
    for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
        const double low = std::max(from, knots[i]);
        const double high = std::min(to, knots[i + 1]);
        if (high <= low) continue;
        const double middle = 0.5 * (low + high);
        const double half = 0.5 * (high - low);
        for (std::size_t g = 0; g < kGaussNodes.size(); ++g)
            total += half * kGaussWeights[g] *
                     (derivative(middle - half * kGaussNodes[g]).norm() +
                      derivative(middle + half * kGaussNodes[g]).norm());
    }
    return total;
}

template <int Dim>
BasicNurbsCurve<Dim> BasicNurbsCurve<Dim>::with_knot(double u) const {
    if (!(u > 0.0 && u < 1.0))
        throw std::invalid_argument("a knot at " + std::to_string(u) + ", expected one inside (0, 1)");
    const int i = basis_.span(u);
    const int d = degree();
    std::vector<double> knots = basis_.knots();
    std::vector<Point> points(control_points_.size() + 1);
    std::vector<double> weights(points.size());
    for (int k = 0; k < static_cast<int>(points.size()); ++k) {
        double a = k <= i - d ? 1.0 : 0.0;
        if (k > i - d && k <= i) {
            const double t = knots[static_cast<std::size_t>(k)];
            a = (u - t) / (knots[static_cast<std::size_t>(k + d)] - t);
        }
        const std::size_t now = static_cast<std::size_t>(k);
        double weight = 0.0;
        Point weighted = Point::Zero();
        if (a > 0.0) {
            weight += a * weights_[now];
            weighted += a * weights_[now] * control_points_[now];
        }
        if (a < 1.0) {
            weight += (1.0 - a) * weights_[now - 1];
            weighted += (1.0 - a) * weights_[now - 1] * control_points_[now - 1];
        }
        points[now] = weighted / weight;
        weights[now] = weight;
    }
    knots.insert(knots.begin() + i + 1, u);
    return {BsplineBasis(d, std::move(knots)), std::move(points), std::move(weights)};
}

template class BasicNurbsCurve<2>;
template class BasicNurbsCurve<3>;

ImageCurve project(const Eigen::Matrix<double, 3, 4>& P, const NurbsCurve& curve) {
    std::vector<Eigen::Vector2d> points;
    std::vector<double> weights;
    for (std::size_t k = 0; k < curve.control_points().size(); ++k) {
        const Eigen::Vector3d h = P * curve.control_points()[k].homogeneous();
        if (h.z() == 0.0)
            throw std::invalid_argument("a control point in the camera's plane, expected one before it");
        points.emplace_back(h.hnormalized());
        weights.push_back(curve.weights()[k] * h.z());  // eq. 3
    }
    return {curve.basis(), std::move(points), std::move(weights)};
}

scenes::Polyline sampled(const NurbsCurve& curve, int count) {
    scenes::Polyline line;
    for (int j = 0; j < count; ++j) line.points.push_back(curve.point(static_cast<double>(j) / (count - 1)));
    return line;
}

NurbsCurve fit_curve(const scenes::Polyline& points, const CurveFitOptions& options) {
    const int K = options.control_points;
    const int M = static_cast<int>(points.points.size());
    if (M < K)
        throw std::invalid_argument(std::to_string(M) + " points for " + std::to_string(K) +
                                    " control points, expected at least as many");
    const BsplineBasis basis(options.degree, K);
    const std::vector<double> s = points.arc_lengths_m();
    const double length = s.back();
    Eigen::MatrixXd N(M, K);
    Eigen::MatrixXd target(M, 3);
    for (int j = 0; j < M; ++j) {
        N.row(j) = basis.row(length > 0.0 ? s[static_cast<std::size_t>(j)] / length : double(j) / (M - 1));
        target.row(j) = points.points[static_cast<std::size_t>(j)];
    }
    // The ends are the points' own; the inner control points are the unknowns.
    Eigen::MatrixXd Q(K, 3);
    Q.row(0) = target.row(0);
    Q.row(K - 1) = target.row(M - 1);
    const Eigen::MatrixXd rest = target - N.col(0) * Q.row(0) - N.col(K - 1) * Q.row(K - 1);
    const Eigen::MatrixXd inner = N.middleCols(1, K - 2);
    Q.middleRows(1, K - 2) = inner.colPivHouseholderQr().solve(rest);

    const BasisTable table = BasisTable::at_midpoints(basis, 10 * K);
    const int unknowns = 3 * (K - 2);
    const double data_weight = 1.0 / M;
    const double length_weight = options.length_weight / static_cast<double>(table.u.size());
    for (int iteration = 0; options.length_weight > 0.0 && iteration < options.iterations; ++iteration) {
        Eigen::MatrixXd H = Eigen::MatrixXd::Zero(unknowns, unknowns);
        Eigen::VectorXd g = Eigen::VectorXd::Zero(unknowns);
        const Eigen::MatrixXd gram = data_weight * inner.transpose() * inner;
        const Eigen::MatrixXd residual = data_weight * inner.transpose() * (N * Q - target);
        for (int a = 0; a < K - 2; ++a) {
            g.segment<3>(3 * a) += residual.row(a);
            for (int b = 0; b < K - 2; ++b)
                H.block<3, 3>(3 * a, 3 * b) += gram(a, b) * Eigen::Matrix3d::Identity();
        }
        for (int j = 0; j < table.derivative.rows(); ++j) {
            const Eigen::Vector3d speed = (table.derivative.row(j) * Q).transpose();
            const double norm = std::max(speed.norm(), 1e-12);
            // Of the inner control points only those that move the curve here.
            const int span = basis.span(table.u[static_cast<std::size_t>(j)]);
            const int first = std::max(span - options.degree, 1) - 1, last = std::min(span, K - 2) - 1;
            const int count = 3 * (last - first + 1);
            Eigen::VectorXd J(count);
            for (int a = first; a <= last; ++a)
                J.segment<3>(3 * (a - first)) = table.derivative(j, a + 1) * speed / norm;
            H.block(3 * first, 3 * first, count, count) += length_weight * J * J.transpose();
            g.segment(3 * first, count) += length_weight * (norm - length) * J;
        }
        const Eigen::VectorXd step = H.ldlt().solve(-g);
        for (int a = 0; a < K - 2; ++a) Q.row(a + 1) += step.segment<3>(3 * a).transpose();
    }
    std::vector<Eigen::Vector3d> control_points;
    for (int k = 0; k < K; ++k) control_points.emplace_back(Q.row(k).transpose());
    return {options.degree, std::move(control_points)};
}

}  // namespace atropos::tracker
