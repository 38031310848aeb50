#include "scenes/random_stream.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace atropos::scenes {
namespace {

TEST(RandomStream, gives_the_committed_vectors) {
    // Computed by an independent implementation of the generators' published definitions.
    RandomStream motion(42, "motion");
    for (const std::uint64_t expected : {0x6ed15a2d69953d37ull, 0x3145691306d7ab3dull, 0x751ce6728399ac8full})
        EXPECT_EQ(motion.next(), expected);
}

TEST(RandomStream, differs_by_seed_and_by_name) {
    EXPECT_NE(RandomStream(1, "a").next(), RandomStream(2, "a").next());
    EXPECT_NE(RandomStream(1, "a").next(), RandomStream(1, "b").next());
    EXPECT_NE(derive_seed(1, 0), derive_seed(1, 1));
}

TEST(RandomStream, streams_of_neighbouring_seeds_and_names_are_uncorrelated) {
    const int n = 100000;
    RandomStream streams[] = {{5, "motion"}, {5, "noise"}, {6, "motion"}, {6, "noise"}};
    double sum[4][4] = {};
    for (int i = 0; i < n; ++i) {
        double x[4];
        for (int k = 0; k < 4; ++k) x[k] = streams[k].normal();
        for (int j = 0; j < 4; ++j)
            for (int k = 0; k < 4; ++k) sum[j][k] += x[j] * x[k];
    }
    // A correlation of independent normals has standard deviation 1/sqrt(n); five of them bound all six
    // pairs.
    for (int j = 0; j < 4; ++j)
        for (int k = 0; k < j; ++k) EXPECT_LT(std::abs(sum[j][k] / n), 5.0 / std::sqrt(n));
}

TEST(RandomStream, distributions_have_their_moments) {
    RandomStream random(9, "moments");
    const int n = 200000;
    double mean = 0, square = 0, uniform = 0;
    int counts[6] = {};
    for (int i = 0; i < n; ++i) {
        const double x = random.normal(1.0, 2.0);
        mean += x / n;
        square += (x - 1.0) * (x - 1.0) / n;
        uniform += random.uniform(2.0, 4.0) / n;
        ++counts[random.integer(6)];
    }
    EXPECT_NEAR(mean, 1.0, 0.03);
    EXPECT_NEAR(square, 4.0, 0.08);
    EXPECT_NEAR(uniform, 3.0, 0.01);
    for (const int c : counts) EXPECT_NEAR(c, n / 6.0, 5 * std::sqrt(n / 6.0));
}

}  // namespace
}  // namespace atropos::scenes
