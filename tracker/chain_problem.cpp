#include "tracker/chain_problem.hpp"

#include <algorithm>

#include "tracker/chain_dp.hpp"
#include "tracker/chain_icm.hpp"

namespace atropos::tracker {

ChainProblem::ChainProblem(int nodes, int labels)
    : nodes_(nodes),
      labels_(labels),
      stride_((labels + 7) / 8 * 8),
      unary_(offset(nodes)),
      pairwise_(offset(std::max(nodes - 1, 0)) * static_cast<std::size_t>(labels)) {
    clear();
}

void ChainProblem::clear() {
    const auto clear_rows = [this](std::vector<float>& table) {
        for (std::size_t i = 0; i < table.size(); ++i)
            table[i] = static_cast<int>(i % static_cast<std::size_t>(stride_)) < labels_ ? 0.0f : kForbidden;
    };
    clear_rows(unary_);
    clear_rows(pairwise_);
}

double ChainProblem::cost(std::span<const int> labelling) const {
    double sum = 0.0;
    for (int p = 0; p < nodes_; ++p) {
        const int l = labelling[static_cast<std::size_t>(p)];
        sum += unary(p)[static_cast<std::size_t>(l)];
        if (p + 1 < nodes_)
            sum += pairwise(
                p)[static_cast<std::size_t>(l * stride_ + labelling[static_cast<std::size_t>(p + 1)])];
    }
    return sum;
}

std::unique_ptr<ChainOptimiser> make_chain_optimiser(scenes::LabelOptimiser kind) {
    if (kind == scenes::LabelOptimiser::kIcm) return std::make_unique<ChainIcm>();
    return std::make_unique<ChainDp>();
}

}  // namespace atropos::tracker
