#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "scenes/worker_pool.hpp"
#include "tracker/chain_problem.hpp"
#include "tracker/energy.hpp"

namespace atropos::tracker {

/// Displacements that each control point may take, laid out for eight at a time: in space, and as the two
/// eyes see them (M l, eq. 3). Same number for every node; label 0 is no displacement.
class NodeLabels {
  public:
    static constexpr int kMost = 200;  ///< labels a node, in whole vectors: enough for r = 8

    /// Throws std::invalid_argument for more than kMost labels.
    NodeLabels(int nodes, int labels);

    /// All labels of a node from displacements in space (m); no cost of their own.
    void set(int node, std::span<const Eigen::Vector3d> displacements, const std::array<Eye, 2>& eyes);

    /// One label: in space, in the homogeneous coordinates of both eyes, and what choosing it costs by
    /// itself.
    void set(int node, int label, const Eigen::Vector3d& displacement,
             const std::array<Eigen::Vector3d, 2>& seen, float cost);

    int labels() const { return labels_; }
    int stride() const { return stride_; }
    Eigen::Vector3d displacement(int node, int label) const { return exact_[index(node, label)].in_space; }
    Eigen::Vector3d seen(int node, int label, std::size_t eye) const {
        return exact_[index(node, label)].seen[eye];
    }
    float cost(int node, int label) const { return exact_[index(node, label)].cost; }

    /// Row of one coordinate: channel 0-2 in C, 3-5 homogeneous left, 6-8 homogeneous right.
    const float* row(int node, int channel) const { return values_.data() + offset(node, channel); }

  private:
    struct Label {
        Eigen::Vector3d in_space = Eigen::Vector3d::Zero();
        std::array<Eigen::Vector3d, 2> seen = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
        float cost = 0.0f;
    };
    std::size_t offset(int node, int channel) const {
        return static_cast<std::size_t>((node * 9 + channel) * stride_);
    }
    std::size_t index(int node, int label) const { return static_cast<std::size_t>(node * labels_ + label); }

    int labels_;
    int stride_;
    std::vector<float> values_;
    std::vector<Label> exact_;
};

/// Fills the chain with one of the paper's two approximations of the energy around a curve. Both are the
/// energy itself when no control point moves.
class Potentials {
  public:
    virtual ~Potentials() = default;
    virtual void fill(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
                      const NodeLabels& labels, scenes::WorkerPool& pool, ChainProblem& chain) = 0;
};

/// First approximation (eq. 10-14): data and length of each node with the others at rest, and |l_p - l_q|.
class PotentialsE1 final : public Potentials {
  public:
    void fill(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
              const NodeLabels& labels, scenes::WorkerPool& pool, ChainProblem& chain) override;
};

/// Second approximation (eq. 15-18): data and length of each pair of neighbours with the others at rest.
class PotentialsE2 final : public Potentials {
  public:
    void fill(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
              const NodeLabels& labels, scenes::WorkerPool& pool, ChainProblem& chain) override;
};

/// Adds the unary costs of measured ends (eq. 19), and those of the labels themselves; a fixed end may not
/// move at all.
void add_node_costs(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
                    const NodeLabels& labels, ChainProblem& chain);

}  // namespace atropos::tracker
