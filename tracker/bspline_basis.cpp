#include "tracker/bspline_basis.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace atropos::tracker {
namespace {

std::vector<double> clamped_uniform_knots(int degree, int count) {
    if (degree < 1 || count <= degree)
        throw std::invalid_argument("a spline of degree " + std::to_string(degree) + " with " +
                                    std::to_string(count) +
                                    " control points, expected degree >= 1 and more points than the degree");
    const int spans = count - degree;
    std::vector<double> knots(static_cast<std::size_t>(count + degree + 1), 0.0);
    for (int i = 0; i <= spans; ++i)
        knots[static_cast<std::size_t>(degree + i)] = static_cast<double>(i) / spans;
    std::fill(knots.end() - degree, knots.end(), 1.0);
    return knots;
}

BasisTable table_at(const BsplineBasis& basis, std::vector<double> u) {
    BasisTable table;
    table.value.resize(static_cast<int>(u.size()), basis.count());
    table.derivative.resize(static_cast<int>(u.size()), basis.count());
    for (std::size_t j = 0; j < u.size(); ++j) {
        table.value.row(static_cast<int>(j)) = basis.row(u[j], 0);
        table.derivative.row(static_cast<int>(j)) = basis.row(u[j], 1);
    }
    table.u = std::move(u);
    return table;
}

}  // namespace

BsplineBasis::BsplineBasis(int degree, int count)
    : BsplineBasis(degree, clamped_uniform_knots(degree, count)) {}

BsplineBasis::BsplineBasis(int degree, std::vector<double> knots)
    : degree_(degree), knots_(std::move(knots)) {
    const bool enough = degree >= 1 && count() > degree;
    const bool clamped = enough && std::is_sorted(knots_.begin(), knots_.end()) && knots_[0] == 0.0 &&
                         knots_[static_cast<std::size_t>(degree)] == 0.0 && knots_.back() == 1.0 &&
                         knots_[static_cast<std::size_t>(count())] == 1.0;
    if (!clamped)
        throw std::invalid_argument(
            "a knot vector that is not clamped, expected degree + 1 zeros, then "
            "nondecreasing values, then degree + 1 ones");
}

std::vector<double> BsplineBasis::distinct_knots() const {
    std::vector<double> distinct = knots_;
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    return distinct;
}

int BsplineBasis::span(double u) const {
    const auto first = knots_.begin() + degree_;
    const auto last = knots_.begin() + count();
    const auto above = std::upper_bound(first, last, std::clamp(u, 0.0, 1.0));
    int i = static_cast<int>(above - knots_.begin()) - 1;
    while (i > degree_ && knots_[static_cast<std::size_t>(i)] == knots_[static_cast<std::size_t>(i + 1)]) --i;
    return i;
}

// Algorithm A2.3 of The NURBS Book: the triangular table of lower degrees gives values and derivatives.
Eigen::MatrixXd BsplineBasis::derivatives(double u, int order) const {
    u = std::clamp(u, 0.0, 1.0);
    const int d = degree_;
    const int i = span(u);
    const auto knot = [this](int k) { return knots_[static_cast<std::size_t>(k)]; };

    Eigen::MatrixXd table(d + 1, d + 1);  // upper triangle: functions, lower: knot differences
    table(0, 0) = 1.0;
    for (int j = 1; j <= d; ++j) {
        double saved = 0.0;
        for (int r = 0; r < j; ++r) {
            const double right = knot(i + r + 1) - u;
            const double left = u - knot(i + 1 - j + r);
            table(j, r) = right + left;
            const double part = table(r, j - 1) / table(j, r);
            table(r, j) = saved + right * part;
            saved = left * part;
        }
        table(j, j) = saved;
    }

    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(order + 1, d + 1);
    result.row(0) = table.col(d).transpose();
    Eigen::MatrixXd a(2, d + 1);
    for (int r = 0; r <= d; ++r) {
        int now = 0;
        a.setZero();
        a(0, 0) = 1.0;
        double factor = d;
        for (int k = 1; k <= std::min(order, d); ++k) {
            const int next = 1 - now;
            a.row(next).setZero();
            double sum = 0.0;
            if (r >= k) {
                a(next, 0) = a(now, 0) / table(d - k + 1, r - k);
                sum = a(next, 0) * table(r - k, d - k);
            }
            const int low = r - k >= -1 ? 1 : k - r;
            const int high = r - 1 <= d - k ? k - 1 : d - r;
            for (int j = low; j <= high; ++j) {
                a(next, j) = (a(now, j) - a(now, j - 1)) / table(d - k + 1, r - k + j);
                sum += a(next, j) * table(r - k + j, d - k);
            }
            if (r <= d - k) {
                a(next, k) = -a(now, k - 1) / table(d - k + 1, r);
                sum += a(next, k) * table(r, d - k);
            }
            result(k, r) = factor * sum;
            factor *= d - k;
            now = next;
        }
    }
    return result;
}

Eigen::VectorXd BsplineBasis::row(double u, int order) const {
    Eigen::VectorXd all = Eigen::VectorXd::Zero(count());
    all.segment(span(u) - degree_, degree_ + 1) = derivatives(u, order).row(order).transpose();
    return all;
}

BasisTable BasisTable::at_midpoints(const BsplineBasis& basis, int samples) {
    std::vector<double> u(static_cast<std::size_t>(samples));
    for (int j = 0; j < samples; ++j) u[static_cast<std::size_t>(j)] = (j + 0.5) / samples;
    return table_at(basis, std::move(u));
}

BasisTable BasisTable::at_steps(const BsplineBasis& basis, int samples) {
    std::vector<double> u(static_cast<std::size_t>(samples));
    for (int j = 0; j < samples; ++j) u[static_cast<std::size_t>(j)] = static_cast<double>(j) / (samples - 1);
    return table_at(basis, std::move(u));
}

}  // namespace atropos::tracker
