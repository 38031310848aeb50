#pragma once

#include <Eigen/Core>
#include <array>

namespace atropos::tracker {

/// A rod that the tracker itself moves: nodes that keep their distances and resist being moved unevenly. Its
/// own stiffness and rest shape are unknown: what it was last seen as is its rest. Constraints by Newton's
/// method along the least displacement, as the projection of Goldenthal, Harmon, Fattal, Bercovier, Grinspun
/// (2007), in the metric of displacement and its bending.
class LightRod {
  public:
    /// `nodes` >= 3. Features of a displacement shorter than `reach` of the rod's length are held back.
    explicit LightRod(int nodes, double reach = 0.1);

    int nodes() const { return nodes_; }

    using Held = std::array<bool, 2>;  ///< ends that stay where they are put

    /// Nodes that are pulled by `by_m` each (m, any frame); held ends are not.
    void pull(const Eigen::Vector3d& by_m, Held held, Eigen::Matrix3Xd& x) const;

    /// Moves `x` to where its edges are as long as those of `before`, by the least displacement. False, and
    /// `x` as it was, where none is near: held ends farther apart than the rod is long.
    bool keep_lengths(const Eigen::Matrix3Xd& before, Held held, Eigen::Matrix3Xd& x) const;

  private:
    const Eigen::MatrixXd& mobility(Held held) const {
        return mobility_[static_cast<std::size_t>((held[0] ? 1 : 0) + (held[1] ? 2 : 0))];
    }

    int nodes_;
    std::array<Eigen::MatrixXd, 4> mobility_;  ///< displacement by force, zero for held nodes
};

}  // namespace atropos::tracker
