#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "scenes/tracker_config.hpp"

namespace atropos::tracker {

/// A chain of discrete variables: node p takes one of `labels` labels, with unary costs V_p(l) and pairwise
/// costs V_pq(l, m) between neighbours (eq. 8, 9). Tables are padded to whole vectors: `stride` >= labels, a
/// multiple of 8, and the padding holds kForbidden.
class ChainProblem {
  public:
    static constexpr float kForbidden = 1e30f;

    ChainProblem(int nodes, int labels);

    int nodes() const { return nodes_; }
    int labels() const { return labels_; }
    int stride() const { return stride_; }

    std::span<float> unary(int p) { return {unary_.data() + offset(p), static_cast<std::size_t>(stride_)}; }
    std::span<const float> unary(int p) const {
        return {unary_.data() + offset(p), static_cast<std::size_t>(stride_)};
    }

    /// Costs of pair (p, p + 1); entry [l * stride + m], l the label of p.
    std::span<float> pairwise(int p) { return {pairwise_.data() + offset(p) * labels_, table_size()}; }
    std::span<const float> pairwise(int p) const {
        return {pairwise_.data() + offset(p) * labels_, table_size()};
    }

    /// Sets every cost to zero.
    void clear();

    /// Cost of a labelling: sum of its unary and pairwise costs, in double.
    double cost(std::span<const int> labelling) const;

  private:
    std::size_t offset(int p) const {
        return static_cast<std::size_t>(p) * static_cast<std::size_t>(stride_);
    }
    std::size_t table_size() const {
        return static_cast<std::size_t>(stride_) * static_cast<std::size_t>(labels_);
    }

    int nodes_;
    int labels_;
    int stride_;
    std::vector<float> unary_;
    std::vector<float> pairwise_;
};

/// Finds a labelling of low cost. Same problem, same labelling: ties go to the lower label.
class ChainOptimiser {
  public:
    virtual ~ChainOptimiser() = default;

    /// `labelling`: one entry a node, overwritten. Returns its cost.
    virtual double minimise(const ChainProblem& problem, std::span<int> labelling) = 0;
};

std::unique_ptr<ChainOptimiser> make_chain_optimiser(scenes::LabelOptimiser kind);

}  // namespace atropos::tracker
