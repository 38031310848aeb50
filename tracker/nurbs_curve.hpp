#pragma once

#include <Eigen/Core>
#include <vector>

#include "scenes/polyline.hpp"
#include "tracker/bspline_basis.hpp"

namespace atropos::tracker {

/// Non-uniform rational B-spline (II-B, eq. 1 and 2): C(u) = sum_k R_k(u) Q_k, u in [0, 1].
/// Dim 3: a curve in space, metres. Dim 2: its image, pixels.
template <int Dim>
class BasicNurbsCurve {
  public:
    using Point = Eigen::Matrix<double, Dim, 1>;

    /// Clamped uniform knots, all weights 1. Throws std::invalid_argument for too few points.
    BasicNurbsCurve(int degree, std::vector<Point> control_points);

    /// Throws std::invalid_argument unless there is one weight a control point, none of them 0.
    BasicNurbsCurve(BsplineBasis basis, std::vector<Point> control_points, std::vector<double> weights);

    int degree() const { return basis_.degree(); }
    const BsplineBasis& basis() const { return basis_; }
    const std::vector<Point>& control_points() const { return control_points_; }
    const std::vector<double>& weights() const { return weights_; }

    /// Replaces the control points, same number. Throws std::invalid_argument.
    void set_control_points(const std::vector<Point>& control_points);

    /// R_k(u) for every control point; they sum to one (eq. 2).
    Eigen::VectorXd rational_basis(double u) const;

    Point point(double u) const;  ///< eq. 1

    /// Derivative of order 1 .. with respect to u (quotient rule, The NURBS Book eq. 4.8).
    Point derivative(double u, int order = 1) const;

    /// Integral of |C'(u)| from `from` to `to`, Gauss-Legendre with 16 points a knot span.
    double length(double from = 0.0, double to = 1.0) const;

    /// The same curve with one more control point (Boehm's knot insertion, The NURBS Book A5.1); 0 < u < 1.
    BasicNurbsCurve with_knot(double u) const;

  private:
    BsplineBasis basis_;
    std::vector<Point> control_points_;
    std::vector<double> weights_;
};

using NurbsCurve = BasicNurbsCurve<3>;
using ImageCurve = BasicNurbsCurve<2>;

extern template class BasicNurbsCurve<2>;
extern template class BasicNurbsCurve<3>;

/// Image of a curve under any projective camera P (3x4): control points P(Q_k), weights w_k P^(3) [Q_k; 1]
/// (eq. 3). Throws std::invalid_argument when a control point lies in the camera's own plane.
ImageCurve project(const Eigen::Matrix<double, 3, 4>& P, const NurbsCurve& curve);

/// `count` >= 2 points at equal steps of u.
scenes::Polyline sampled(const NurbsCurve& curve, int count);

struct CurveFitOptions {
    int degree = 3;
    int control_points = 8;
    double length_weight =
        0.0;              ///< pulls |C'(u)| towards the points' length (eq. 7); 0 = plain least squares
    int iterations = 20;  ///< Gauss-Newton steps of the length term
};

/// Curve nearest to `points` in least squares, parameters by arc length, ends interpolated. Throws
/// std::invalid_argument for fewer points than control points.
NurbsCurve fit_curve(const scenes::Polyline& points, const CurveFitOptions& options);

}  // namespace atropos::tracker
