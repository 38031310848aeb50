#pragma once

#include <array>
#include <vector>

#include "tracker/bspline_basis.hpp"

namespace atropos::tracker {

/// The four cubic B-spline functions that are not zero at one parameter, and their derivatives: those of
/// control points first ... first + 3.
struct CubicBasisValues {
    int first = 0;
    std::array<double, 4> value{};
    std::array<double, 4> derivative{};         ///< by u
    std::array<double, 4> second_derivative{};  ///< by u

    /// Sum of value_i Q_{first + i} over the columns of a 3xK matrix; the same with the derivatives.
    template <class Points>
    auto point(const Points& Q) const {
        return combined(value, Q);
    }
    template <class Points>
    auto tangent(const Points& Q) const {
        return combined(derivative, Q);
    }
    template <class Points>
    auto bend(const Points& Q) const {
        return combined(second_derivative, Q);
    }

  private:
    template <class Points>
    auto combined(const std::array<double, 4>& w, const Points& Q) const {
        return (w[0] * Q.col(first) + w[1] * Q.col(first + 1) + w[2] * Q.col(first + 2) +
                w[3] * Q.col(first + 3))
            .eval();
    }
};

/// BsplineBasis of degree 3 without allocation, for what is evaluated at parameters not known beforehand.
class CubicBasis {
  public:
    /// Clamped uniform knots. Throws std::invalid_argument unless count >= 4.
    explicit CubicBasis(int count) : basis_(3, count) {}

    int count() const { return basis_.count(); }
    const BsplineBasis& basis() const { return basis_; }

    CubicBasisValues at(double u) const;

    /// At the midpoints (j + 1/2) / samples.
    std::vector<CubicBasisValues> at_midpoints(int samples) const;

  private:
    BsplineBasis basis_;
};

}  // namespace atropos::tracker
