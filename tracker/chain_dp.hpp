#pragma once

#include <span>
#include <vector>

#include "tracker/chain_problem.hpp"

namespace atropos::tracker {

/// Exact minimum of a chain for any costs, by dynamic programming (Viterbi): nodes x labels^2 steps.
class ChainDp final : public ChainOptimiser {
  public:
    double minimise(const ChainProblem& problem, std::span<int> labelling) override;

    /// Lowest cost of the whole chain with node p at label l, for all p and l: [p * stride + l]. The smallest
    /// of each node is the minimum; the others say how well the node is determined.
    std::span<const float> min_marginals(const ChainProblem& problem);

  private:
    void forward(const ChainProblem& problem);
    void backward(const ChainProblem& problem);

    std::vector<float> forward_;   ///< cheapest way to (p, l) from the left, unary of p included
    std::vector<float> backward_;  ///< from the right, unary of p left out
    std::vector<int> predecessor_;
    std::vector<float> marginals_;
};

}  // namespace atropos::tracker
