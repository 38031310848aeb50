#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace atropos::tracker {

/// Normal equations of a cubic spline in space with one unknown more that touches every row, such as its
/// length: [A b; b' c] [x; y] = [g; h], A symmetric with half-bandwidth 11 (four neighbouring control
/// points). Nothing is allocated after construction.
class BorderedBandSystem {
  public:
    static constexpr int kBand = 12;  ///< diagonal and 11 below
    using Block = Eigen::Matrix<double, 12, 1>;

    explicit BorderedBandSystem(int control_points);

    int unknowns() const { return n_; }
    void set_zero();

    /// One residual r with derivative `J` by control points first ... first + 3 (12 numbers, point by point)
    /// and `border_J` by the border's unknown, all over sigma, times an IRLS weight.
    void add(int first_control_point, const Block& J, double border_J, double r, double weight);

    /// Adds `damping` times the diagonal to it, factors and solves for the step that lowers the residuals.
    /// False when the matrix is not positive definite.
    bool solve(double damping, Eigen::VectorXd& step, double& border_step);

    /// Inverse of the whole matrix (without damping), restricted to the curve: the border's unknown is
    /// marginalised. `covariance` is 3K x 3K; `border_variance` that of the other. False as above.
    bool covariance(Eigen::MatrixXd& covariance, double& border_variance);

  private:
    bool factor(double damping);
    void substitute(Eigen::VectorXd& x) const;

    int n_;
    std::vector<std::array<double, kBand>> A_;  ///< row i holds A(i, i - 11 ... i)
    std::vector<std::array<double, kBand>> L_;
    Eigen::VectorXd b_, g_, y_;
    double c_ = 0.0, h_ = 0.0;
};

}  // namespace atropos::tracker
