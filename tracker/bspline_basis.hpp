#pragma once

#include <Eigen/Core>
#include <vector>

namespace atropos::tracker {

/// B-spline basis functions N_{k,d} over a clamped knot vector on [0, 1] (eq. 2; Piegl and Tiller, The NURBS
/// Book, ch. 2). Clamped: the first and last d + 1 knots are 0 and 1, so a curve begins and ends at its outer
/// control points.
class BsplineBasis {
  public:
    /// Clamped uniform knots. Throws std::invalid_argument unless degree >= 1 and count > degree.
    BsplineBasis(int degree, int count);

    /// `knots`: count + degree + 1 values, nondecreasing, clamped to 0 and 1. Throws std::invalid_argument.
    BsplineBasis(int degree, std::vector<double> knots);

    int degree() const { return degree_; }
    int count() const { return static_cast<int>(knots_.size()) - degree_ - 1; }
    const std::vector<double>& knots() const { return knots_; }
    std::vector<double> distinct_knots() const;

    /// Index i of the knot span [t_i, t_{i+1}) that holds u; u is clamped to [0, 1], u = 1 belongs to the
    /// last.
    int span(double u) const;

    /// Values and derivatives of order 0..`order` of the degree + 1 functions that are not zero at u: those
    /// of control points span(u) - degree ... span(u). Row = order, column = function.
    Eigen::MatrixXd derivatives(double u, int order) const;

    /// All `count` functions at u, derivative of the given order; zeros outside the span.
    Eigen::VectorXd row(double u, int order = 0) const;

  private:
    int degree_;
    std::vector<double> knots_;
};

/// The basis at fixed parameters: one row a sample, one column a control point.
struct BasisTable {
    std::vector<double> u;
    Eigen::MatrixXd value;       ///< N_k(u_j)
    Eigen::MatrixXd derivative;  ///< N_k'(u_j)

    /// Midpoints (j + 1/2) / samples.
    static BasisTable at_midpoints(const BsplineBasis& basis, int samples);

    /// `samples` >= 2 equal steps of u, ends included.
    static BasisTable at_steps(const BsplineBasis& basis, int samples);
};

}  // namespace atropos::tracker
