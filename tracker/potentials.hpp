#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "tracker/chain_problem.hpp"
#include "tracker/energy.hpp"
#include "tracker/worker_pool.hpp"

namespace atropos::tracker {

/// Displacements that each control point may take, laid out for eight at a time: in space, and as the two
/// eyes see them (M l, eq. 3). Same number for every node; label 0 is no displacement.
class NodeLabels {
  public:
    NodeLabels(int nodes, int labels);

    void set(int node, std::span<const Eigen::Vector3d> displacements, const std::array<Eye, 2>& eyes);

    int labels() const { return labels_; }
    int stride() const { return stride_; }
    Eigen::Vector3d displacement(int node, int label) const;

    /// Row of one coordinate: channel 0-2 in C, 3-5 homogeneous left, 6-8 homogeneous right.
    const float* row(int node, int channel) const { return values_.data() + offset(node, channel); }

  private:
    std::size_t offset(int node, int channel) const {
        return static_cast<std::size_t>((node * 9 + channel) * stride_);
    }
    int labels_;
    int stride_;
    std::vector<float> values_;
    std::vector<Eigen::Vector3d> exact_;
};

/// Fills the chain with one of the paper's two approximations of the energy around a curve. Both are the
/// energy itself when no control point moves.
class Potentials {
  public:
    virtual ~Potentials() = default;
    virtual void fill(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
                      const NodeLabels& labels, WorkerPool& pool, ChainProblem& chain) = 0;
};

/// First approximation (eq. 10-14): data and length of each node with the others at rest, and |l_p - l_q|.
class PotentialsE1 final : public Potentials {
  public:
    void fill(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
              const NodeLabels& labels, WorkerPool& pool, ChainProblem& chain) override;
};

/// Second approximation (eq. 15-18): data and length of each pair of neighbours with the others at rest.
class PotentialsE2 final : public Potentials {
  public:
    void fill(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
              const NodeLabels& labels, WorkerPool& pool, ChainProblem& chain) override;
};

/// Adds the unary costs of measured ends (eq. 19); a fixed end may not move at all.
void add_tip_costs(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
                   const NodeLabels& labels, ChainProblem& chain);

}  // namespace atropos::tracker
