#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "tracker/bspline_basis.hpp"

namespace atropos::tracker {

/// The integrals over u of the energies as sums over midpoints u_j, du = 1 / samples, with the weights of
/// both approximations. The 3D weights w_k are 1 (II-B), so R_k = N_k. At midpoints the denominator of eq. 18
/// is never 0; at u = 0 and 1 it is.
class CurveSampling {
  public:
    CurveSampling(int degree, int control_points, int samples);

    int samples() const { return static_cast<int>(table_.u.size()); }
    int control_points() const { return static_cast<int>(table_.value.cols()); }
    double du() const { return 1.0 / samples(); }
    double R(int k, int j) const { return table_.value(j, k); }
    double dR(int k, int j) const { return table_.derivative(j, k); }

    double alpha(int p, int j) const { return table_.value(j, p); }      ///< eq. 14
    double alpha_pair(int p, int j) const { return alpha_pair_(j, p); }  ///< eq. 18, q = p + 1

    /// Samples where R_p is not 0, and where R_p R_{p+1} is not: [first, last).
    struct Range {
        int first;
        int last;
    };
    Range support(int p) const { return support_[static_cast<std::size_t>(p)]; }
    Range pair_support(int p) const { return pair_support_[static_cast<std::size_t>(p)]; }

    /// C(u_j) and C'(u_j) of the curve with these control points.
    Eigen::Vector3d point(std::span<const Eigen::Vector3d> control_points, int j) const;
    Eigen::Vector3d velocity(std::span<const Eigen::Vector3d> control_points, int j) const;

  private:
    BasisTable table_;
    Eigen::MatrixXd alpha_pair_;
    std::vector<Range> support_;
    std::vector<Range> pair_support_;
};

}  // namespace atropos::tracker
