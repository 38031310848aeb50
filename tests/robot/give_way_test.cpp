#include "robot/give_way.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "scenes/random_stream.hpp"

namespace atropos::robot {
namespace {

using Eigen::Vector3d;

scenes::Capsule random_capsule(scenes::RandomStream& random) {
    const auto point = [&] {
        return Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    };
    return {point(), point(), random.uniform(0.01, 0.05)};
}

TEST(Nearest, agrees_with_a_search_over_points_and_points_the_way_out) {
    scenes::RandomStream random(3, "test.nearest");
    for (int n = 0; n < 50; ++n) {
        std::vector<scenes::Capsule> own = {random_capsule(random), random_capsule(random)};
        const std::vector<scenes::Capsule> others = {random_capsule(random), random_capsule(random)};
        const Nearest found = nearest(own, others);
        double least = 1.0;
        for (const auto& a : own)
            for (const auto& b : others)
                for (int i = 0; i <= 200; ++i) {
                    const Vector3d p = a.a + 0.005 * i * (a.b - a.a);
                    least = std::min(least, scenes::clearance_m(b, p) - a.radius_m);
                }
        EXPECT_NEAR(found.clearance_m, least, 2e-3);
        EXPECT_LE(found.clearance_m, least + 1e-12);
        for (auto& c : own) c = {c.a + 1e-6 * found.away, c.b + 1e-6 * found.away, c.radius_m};
        EXPECT_GT(nearest(own, others).clearance_m, found.clearance_m);
    }
}

TEST(Nearest, of_nothing_is_far) {
    EXPECT_EQ(nearest({}, {}).clearance_m, 1.0);
}

TEST(GiveWay, keeps_clear_of_what_comes_and_comes_back_when_it_has_gone) {
    GiveWay give_way;
    double least_m = 1.0;
    for (int tick = 0; tick < 6000; ++tick) {
        const double t = 1e-3 * tick, wall_m = 0.02 - 0.03 * std::max(0.0, 1.0 - std::abs(t - 1.5));
        const double clearance_m = give_way.offset_m().x() + wall_m;
        least_m = std::min(least_m, clearance_m);
        give_way.step({clearance_m, Vector3d::UnitX()});
    }
    EXPECT_GT(least_m, 0.002);
    EXPECT_LT(give_way.offset_m().norm(), 1e-4);
    EXPECT_FALSE(GiveWay().is_aside());
}

}  // namespace
}  // namespace atropos::robot
