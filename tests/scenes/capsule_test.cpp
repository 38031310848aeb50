#include "scenes/capsule.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "scenes/random_stream.hpp"

namespace atropos::scenes {
namespace {

TEST(Capsule, distance_of_segments_is_never_above_a_dense_search) {
    RandomStream random(3, "segments");
    const auto point = [&] { return Eigen::Vector3d(random.normal(), random.normal(), random.normal()); };
    for (int i = 0; i < 100; ++i) {
        const Eigen::Vector3d a = point(), b = point(), c = point(), d = point();
        const double found = segment_distance(a, b, c, d).distance_m;
        double best = 1e9;
        for (int j = 0; j <= 200; ++j)
            for (int k = 0; k <= 200; ++k)
                best = std::min(best, (a + (b - a) * j / 200.0 - c - (d - c) * k / 200.0).norm());
        EXPECT_LE(found, best + 1e-12);
        EXPECT_GE(found, best - 0.05);
    }
}

TEST(Capsule, clearance_of_crossed_rods_is_their_gap) {
    const Capsule first{{-1, 0, 0}, {1, 0, 0}, 0.1}, second{{0, -1, 0.5}, {0, 1, 0.5}, 0.2};
    EXPECT_NEAR(clearance_m(first, second), 0.2, 1e-15);
    EXPECT_NEAR(clearance_m(first, Eigen::Vector3d(2, 0, 0)), 0.9, 1e-15);
    EXPECT_LT(clearance_m(first, Eigen::Vector3d(0, 0, 0)), 0.0);
}

TEST(Capsule, degenerate_and_parallel_segments_have_a_distance) {
    const Eigen::Vector3d o(0, 0, 0), x(1, 0, 0), y(0, 1, 0);
    EXPECT_DOUBLE_EQ(segment_distance(o, o, y, y).distance_m, 1.0);
    EXPECT_DOUBLE_EQ(segment_distance(o, x, y, x + y).distance_m, 1.0);
    EXPECT_DOUBLE_EQ(segment_distance(o, x, 3 * x, 4 * x).distance_m, 2.0);
}

}  // namespace
}  // namespace atropos::scenes
