#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace atropos::tracker {

/// Normal equations of a cubic spline in space with a few unknowns more that touch every row, such as its
/// length: [A B; B' C] [x; y] = [g; h], A symmetric with half-bandwidth 11 (four neighbouring control
/// points), y the border. Nothing is allocated after construction.
class BorderedBandSystem {
  public:
    static constexpr int kBand = 12;  ///< diagonal and 11 below
    static constexpr int kMostBorder = 12;
    using Block = Eigen::Matrix<double, kBand, 1>;
    using Border = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostBorder, 1>;
    using BorderMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostBorder, kMostBorder>;

    /// Inverse of the whole matrix, without damping.
    struct Covariance {
        Eigen::MatrixXd curve;   ///< 3K x 3K, the border marginalised
        Eigen::MatrixXd across;  ///< 3K x border
        BorderMatrix border;
    };

    BorderedBandSystem(int control_points, int border);

    int unknowns() const { return n_; }
    int border() const { return static_cast<int>(h_.size()); }
    void set_zero();

    /// One residual r with derivative `J` by control points first ... first + 3 (12 numbers, point by point),
    /// all over sigma, times an IRLS weight.
    void add(int first_control_point, const Block& J, double r, double weight);

    /// The same of a residual that depends on the border too.
    void add(int first_control_point, const Block& J, const Border& border_J, double r, double weight);

    /// A Gaussian prior on the border alone, `error` from its mean.
    void add_border(const BorderMatrix& information, const Border& error);

    /// Adds `damping` times the diagonal to it, factors and solves for the step that lowers the residuals.
    /// False when the matrix is not positive definite.
    bool solve(double damping, Eigen::VectorXd& step, Border& border_step);

    /// False as above.
    bool covariance(Covariance& out);

  private:
    bool factor(double damping);
    bool eliminate_curve(double damping);
    template <class Column>
    void substitute(Column&& x) const;

    int n_;
    std::vector<std::array<double, kBand>> A_;  ///< row i holds A(i, i - 11 ... i)
    std::vector<std::array<double, kBand>> L_;
    Eigen::VectorXd g_;
    Eigen::MatrixXd B_, Y_;  ///< Y = A^-1 B
    Border h_;
    BorderMatrix C_, schur_inverse_;
};

}  // namespace atropos::tracker
