#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <limits>

#include "scenes/random_stream.hpp"
#include "tracker/chain_dp.hpp"
#include "tracker/chain_icm.hpp"

namespace atropos::tracker {
namespace {

ChainProblem random_chain(std::uint64_t seed, int nodes, int labels) {
    scenes::RandomStream random(seed, "chain");
    ChainProblem chain(nodes, labels);
    for (int p = 0; p < nodes; ++p) {
        for (int l = 0; l < labels; ++l) {
            chain.unary(p)[static_cast<std::size_t>(l)] = static_cast<float>(random.uniform(0.0, 10.0));
            if (p + 1 < nodes)
                for (int m = 0; m < labels; ++m)
                    chain.pairwise(p)[static_cast<std::size_t>(l * chain.stride() + m)] =
                        static_cast<float>(random.uniform(0.0, 10.0));
        }
    }
    return chain;
}

/// Calls `visit` with every labelling of the chain.
template <typename Visit>
void for_each_labelling(const ChainProblem& chain, Visit&& visit) {
    std::vector<int> labelling(static_cast<std::size_t>(chain.nodes()), 0);
    while (true) {
        visit(labelling);
        std::size_t p = 0;
        while (p < labelling.size() && ++labelling[p] == chain.labels()) labelling[p++] = 0;
        if (p == labelling.size()) return;
    }
}

TEST(ChainDp, finds_the_minimum_of_every_small_chain) {
    ChainDp dp;
    for (int nodes = 1; nodes <= 4; ++nodes)
        for (int labels = 1; labels <= 9; ++labels)
            for (std::uint64_t seed = 0; seed < 5; ++seed) {
                const ChainProblem chain = random_chain(seed, nodes, labels);
                double lowest = std::numeric_limits<double>::infinity();
                for_each_labelling(
                    chain, [&](const std::vector<int>& l) { lowest = std::min(lowest, chain.cost(l)); });
                std::vector<int> found(static_cast<std::size_t>(nodes));
                EXPECT_NEAR(dp.minimise(chain, found), lowest, 1e-5);
            }
}

TEST(ChainDp, knows_the_lowest_cost_through_every_label) {
    ChainDp dp;
    const ChainProblem chain = random_chain(3, 4, 6);
    std::vector<double> lowest(4 * 6, std::numeric_limits<double>::infinity());
    for_each_labelling(chain, [&](const std::vector<int>& l) {
        for (std::size_t p = 0; p < 4; ++p) {
            double& best = lowest[p * 6 + static_cast<std::size_t>(l[p])];
            best = std::min(best, chain.cost(l));
        }
    });
    const std::span<const float> marginals = dp.min_marginals(chain);
    for (std::size_t p = 0; p < 4; ++p)
        for (std::size_t l = 0; l < 6; ++l)
            EXPECT_NEAR(marginals[p * static_cast<std::size_t>(chain.stride()) + l], lowest[p * 6 + l], 1e-5);
}

TEST(ChainDp, is_never_above_iterated_conditional_modes) {
    ChainDp dp;
    ChainIcm icm;
    int strictly_below = 0;
    for (std::uint64_t seed = 0; seed < 1000; ++seed) {
        const ChainProblem chain = random_chain(seed, 8, 29);
        std::vector<int> exact(8);
        std::vector<int> local(8);
        const double best = dp.minimise(chain, exact);
        const double good = icm.minimise(chain, local);
        ASSERT_LE(best, good + 1e-5);
        strictly_below += best < good - 1e-5 ? 1 : 0;
    }
    EXPECT_GT(strictly_below, 900);  // random costs have many local minima
}

TEST(ChainDp, takes_the_lower_of_two_equal_labels) {
    const ChainProblem chain(5, 7);
    std::vector<int> found(5, 3);
    ChainDp().minimise(chain, found);
    EXPECT_THAT(found, testing::Each(0));
}

}  // namespace
}  // namespace atropos::tracker
