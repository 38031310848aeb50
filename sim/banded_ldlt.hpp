#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace atropos::sim {

/// LDL^T of a symmetric positive definite matrix of half-bandwidth 8: three coordinates a node, each node
/// coupled to its two neighbours on either side, which is what stretching and bending of a rod give.
class BandedLdlt {
  public:
    /// Zero matrix of `rows` rows, three a node.
    void reset(int rows);
    int rows() const { return rows_; }

    /// Adds `block` at the rows of node `row_node` and the columns of `column_node` <= row_node; of a
    /// diagonal block only the lower triangle is read.
    void add_block(int row_node, int column_node, const Eigen::Matrix3d& block) {
        Block& to = at(column_node)[static_cast<size_t>(row_node - column_node)];
        for (int c = 0; c < 3; ++c) to[static_cast<size_t>(c)].head<3>() += block.col(c);
    }

    /// Adds `value` times the identity to a node's diagonal block.
    void add_diagonal(int node, double value) {
        for (int c = 0; c < 3; ++c) at(node)[0][static_cast<size_t>(c)][c] += value;
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
    // Three columns of three rows; the fourth row is zero and makes a column one register.
    using Block = std::array<Eigen::Vector4d, 3>;
    // Of one node's columns: its own rows, the next node's, and those of the one after.
    using Columns = std::array<Block, 3>;

    Columns& at(int node) { return columns_[static_cast<size_t>(node)]; }
    template <int kCount>
    void solve_panel(double* panel, int width, int first_row) const;

    int rows_ = 0;
    std::vector<Columns> columns_;  // two more than nodes, so that no node lacks the two after it
    std::vector<double> inverse_pivots_;
};

}  // namespace atropos::sim
