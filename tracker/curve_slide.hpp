#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "tracker/cubic_basis.hpp"
#include "tracker/curve_refinement.hpp"

namespace atropos::tracker {

/// Another spline through the points of a curve, by interpolation at Greville's abscissae.
class CurveInterpolation {
  public:
    explicit CurveInterpolation(const CubicBasis& basis);

    /// Control points (3 x K of this basis) of C(u + by_u), where C has the control points `Q` of `from`;
    /// straight on beyond its ends.
    Eigen::Matrix3Xd carried_over(const CubicBasis& from, const Eigen::Matrix3Xd& Q, double by_u = 0.0) const;

  private:
    std::vector<double> greville_;
    Eigen::MatrixXd to_control_points_;  ///< of values at the abscissae, transposed
};

/// How far (m) the ends' priors want a curve to move along itself, from its first end towards its last.
/// Images say nothing of that motion, and Newton's steps, which go straight on, follow a bend by no more than
/// tenths of a millimetre: a loop that is drawn along its thread runs away from them.
double wanted_slide_m(const std::array<std::optional<EndPrior>, 2>& ends, const Eigen::Matrix3Xd& Q);

/// Control points, in steps of eight from 16 to 40, that a thread needs: for its length, and to follow the
/// bends of the curve `Q`.
int needed_control_points(double length_m);
int needed_control_points(const CubicBasis& basis, const Eigen::Matrix3Xd& Q, double length_m);

}  // namespace atropos::tracker
