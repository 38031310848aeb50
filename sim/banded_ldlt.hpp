#pragma once

#include <Eigen/Core>
#include <vector>

namespace atropos::sim {

/// LDL^T of a symmetric positive definite matrix of half-bandwidth 8: three coordinates a node, each node
/// coupled to its two neighbours on either side, which is what stretching and bending of a rod give.
class BandedLdlt {
  public:
    static constexpr int kHalfBandwidth = 8;

    /// Zero matrix of `rows` rows.
    void reset(int rows);
    int rows() const { return rows_; }

    /// Adds `block` at the rows of node `row_node` and the columns of `column_node` <= row_node; of a
    /// diagonal block only the lower triangle is read.
    void add_block(int row_node, int column_node, const Eigen::Matrix3d& block) {
        const int diagonal = 3 * (row_node - column_node);
        for (int c = 0; c < 3; ++c) {
            double* column = &columns_[static_cast<size_t>((3 * column_node + c) * kStride)];
            for (int r = diagonal == 0 ? c : 0; r < 3; ++r) column[diagonal + r - c] += block(r, c);
        }
    }

    /// Adds `value` times the identity to a node's diagonal block.
    void add_diagonal(int node, double value) {
        for (int c = 0; c < 3; ++c) columns_[static_cast<size_t>((3 * node + c) * kStride)] += value;
    }

    /// Replaces the rows and columns of a node by the identity.
    void fix_node(int node);

    /// Factors in place; false when a pivot is not positive and finite.
    bool factor();

    /// Solves in place for one right-hand side.
    void solve(Eigen::VectorXd& b) const;

    /// Solves in place for several, stored row by row with `width` a multiple of 4; rows before `first_row`
    /// are zero in all of them and are not solved for.
    void solve(std::vector<double>& b, int width, int first_row) const;

  private:
    // Column j holds A(j, j), A(j+1, j), ..., A(j+8, j), then zeros, so that the inner loops have a fixed
    // length.
    static constexpr int kStride = 16;
    int rows_ = 0;
    std::vector<double> columns_;
    std::vector<double> inverse_pivots_;
};

}  // namespace atropos::sim
