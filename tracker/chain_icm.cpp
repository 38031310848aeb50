#include "tracker/chain_icm.hpp"

#include <algorithm>

namespace atropos::tracker {
namespace {

int best_label(const ChainProblem& problem, int p, std::span<const int> labelling) {
    const std::size_t stride = static_cast<std::size_t>(problem.stride());
    const std::size_t node = static_cast<std::size_t>(p);
    const auto cost_of = [&](int l) {
        const std::size_t label = static_cast<std::size_t>(l);
        float cost = problem.unary(p)[label];
        if (p > 0)
            cost += problem.pairwise(p - 1)[static_cast<std::size_t>(labelling[node - 1]) * stride + label];
        if (p + 1 < problem.nodes())
            cost += problem.pairwise(p)[label * stride + static_cast<std::size_t>(labelling[node + 1])];
        return cost;
    };
    int best = labelling[node];
    float lowest = cost_of(best);
    for (int l = 0; l < problem.labels(); ++l)
        if (const float cost = cost_of(l); cost < lowest) {
            lowest = cost;
            best = l;
        }
    return best;
}

}  // namespace

double ChainIcm::minimise(const ChainProblem& problem, std::span<int> labelling) {
    std::fill(labelling.begin(), labelling.end(), 0);
    constexpr int kSweeps = 100;  // rounding could make two labels change places for ever
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        bool changed = false;
        for (int p = 0; p < problem.nodes(); ++p) {
            const int label = best_label(problem, p, labelling);
            changed |= label != labelling[static_cast<std::size_t>(p)];
            labelling[static_cast<std::size_t>(p)] = label;
        }
        if (!changed) break;
    }
    return problem.cost(labelling);
}

}  // namespace atropos::tracker
