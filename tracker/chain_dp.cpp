#include "tracker/chain_dp.hpp"

#include <algorithm>

namespace atropos::tracker {

void ChainDp::forward(const ChainProblem& problem) {
    const std::size_t stride = static_cast<std::size_t>(problem.stride());
    forward_.resize(stride * static_cast<std::size_t>(problem.nodes()));
    predecessor_.resize(forward_.size());
    std::copy(problem.unary(0).begin(), problem.unary(0).end(), forward_.begin());
    for (int p = 1; p < problem.nodes(); ++p) {
        const float* before = forward_.data() + static_cast<std::size_t>(p - 1) * stride;
        float* now = forward_.data() + static_cast<std::size_t>(p) * stride;
        int* from = predecessor_.data() + static_cast<std::size_t>(p) * stride;
        const float* pairwise = problem.pairwise(p - 1).data();
        const float* unary = problem.unary(p).data();
        std::fill(now, now + stride, 2.0f * ChainProblem::kForbidden);
        for (int l = 0; l < problem.labels(); ++l) {
            const float cost = before[l];
            const float* row = pairwise + static_cast<std::size_t>(l) * stride;
            for (std::size_t m = 0; m < stride; ++m) {
                const float through = cost + row[m];
                from[m] = through < now[m] ? l : from[m];
                now[m] = through < now[m] ? through : now[m];
            }
        }
        for (std::size_t m = 0; m < stride; ++m) now[m] += unary[m];
    }
}

void ChainDp::backward(const ChainProblem& problem) {
    const std::size_t stride = static_cast<std::size_t>(problem.stride());
    backward_.resize(stride * static_cast<std::size_t>(problem.nodes()));
    std::fill(backward_.end() - problem.stride(), backward_.end(), 0.0f);
    for (int p = problem.nodes() - 2; p >= 0; --p) {
        const float* after = backward_.data() + static_cast<std::size_t>(p + 1) * stride;
        float* now = backward_.data() + static_cast<std::size_t>(p) * stride;
        const float* unary = problem.unary(p + 1).data();
        const float* pairwise = problem.pairwise(p).data();
        for (int l = 0; l < problem.labels(); ++l) {
            const float* row = pairwise + static_cast<std::size_t>(l) * stride;
            float best = 2.0f * ChainProblem::kForbidden;
            for (int m = 0; m < problem.labels(); ++m) best = std::min(best, row[m] + unary[m] + after[m]);
            now[l] = best;
        }
    }
}

double ChainDp::minimise(const ChainProblem& problem, std::span<int> labelling) {
    forward(problem);
    const std::size_t stride = static_cast<std::size_t>(problem.stride());
    const int last = problem.nodes() - 1;
    const float* end = forward_.data() + static_cast<std::size_t>(last) * stride;
    int label = static_cast<int>(std::min_element(end, end + problem.labels()) - end);
    for (int p = last; p >= 0; --p) {
        labelling[static_cast<std::size_t>(p)] = label;
        if (p > 0)
            label = predecessor_[static_cast<std::size_t>(p) * stride + static_cast<std::size_t>(label)];
    }
    return problem.cost(labelling);
}

std::span<const float> ChainDp::min_marginals(const ChainProblem& problem) {
    forward(problem);
    backward(problem);
    marginals_.resize(forward_.size());
    for (std::size_t i = 0; i < marginals_.size(); ++i) marginals_[i] = forward_[i] + backward_[i];
    return marginals_;
}

}  // namespace atropos::tracker
