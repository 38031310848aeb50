#pragma once

#include "tracker/chain_problem.hpp"

namespace atropos::tracker {

/// Iterated conditional modes (Besag 1986): each node in turn takes its best label given its neighbours, from
/// label 0 everywhere, until nothing changes. A local minimum; the comparison to `ChainDp`.
class ChainIcm final : public ChainOptimiser {
  public:
    double minimise(const ChainProblem& problem, std::span<int> labelling) override;
};

}  // namespace atropos::tracker
