#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "sim/banded_ldlt.hpp"
#include "sim/thread_dynamics.hpp"

namespace atropos::sim {

/// Two edges of a thread that are close in space and far enough apart along it.
struct EdgePair {
    int a;
    int b;
    bool operator==(const EdgePair&) const = default;
};

/// All pairs with a < b whose axes may be closer than `reach_m`, in order. Pairs nearer than three edges
/// or 1.5 diameters along the thread are left out: they are neighbours, not contacts.
std::vector<EdgePair> near_edge_pairs(const ThreadState& state, const std::vector<Eigen::Vector3d>& x,
                                      double diameter_m, double reach_m);

/// Closest points of two edges.
struct EdgeApproach {
    double s, t;                  ///< on a and on b, 0 to 1
    Eigen::Vector3d from_b_to_a;  ///< m
    double distance_m;
};
EdgeApproach edge_approach(const std::vector<Eigen::Vector3d>& x, const EdgePair& pair);

/// Hard contacts of a thread with itself, with Coulomb friction: non-penetration and friction are conditions
/// on the displacement over the step, solved by projected Gauss-Seidel on the Delassus matrix J A^-1 J^T of
/// the rod's own factorised matrix A.
class SelfContactSolver {
  public:
    struct Contact {
        EdgePair pair;
        double s, t;
        Eigen::Matrix3d axes;  ///< rows: normal from b to a, and two tangents
        double gap_m;          ///< between the surfaces, at the present nodes
        Eigen::Vector3d slid;  ///< displacement a against b since the start of the step, world axes
        Eigen::Vector3d lambda = Eigen::Vector3d::Zero();  ///< force, contact axes
    };

    /// Keeps last step's forces as the first guess of pairs that persist.
    void begin_step(std::vector<EdgePair> near_pairs) {
        near_ = std::move(near_pairs);
        if (near_.empty()) contacts_.clear();
    }
    const std::vector<EdgePair>& near_pairs() const { return near_; }
    bool empty() const { return contacts_.empty(); }
    int count() const { return static_cast<int>(contacts_.size()); }

    /// Contacts among the near pairs at nodes `x`, the step having started from `x_start`.
    void find(const std::vector<Eigen::Vector3d>& x, const std::vector<Eigen::Vector3d>& x_start,
              double diameter_m, double margin_m);

    /// Forces for the factorised matrix and the unconstrained step `free_step`; returns J^T lambda.
    /// `fixed` marks nodes that do not move.
    Eigen::VectorXd solve(const BandedLdlt& matrix, const Eigen::VectorXd& free_step, double friction,
                          const std::vector<char>& fixed);

    void clear() { near_.clear(), contacts_.clear(), previous_.clear(); }

  private:
    std::vector<EdgePair> near_;
    std::vector<Contact> contacts_, previous_;
    std::vector<double> columns_;
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> delassus_;
};

}  // namespace atropos::sim
