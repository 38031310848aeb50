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

TEST(Neighbourhood, has_the_clearance_that_a_search_over_points_finds) {
    scenes::RandomStream random(3, "test.nearest");
    for (int n = 0; n < 50; ++n) {
        std::vector<scenes::Capsule> own = {random_capsule(random), random_capsule(random)};
        const std::vector<scenes::Capsule> others = {random_capsule(random), random_capsule(random)};
        const Neighbourhood found = neighbourhood(own, others, 0.0);
        double least = 1.0;
        for (const auto& a : own)
            for (const auto& b : others)
                for (int i = 0; i <= 200; ++i) {
                    const Vector3d p = a.a + 0.005 * i * (a.b - a.a);
                    least = std::min(least, scenes::clearance_m(b, p) - a.radius_m);
                }
        EXPECT_NEAR(found.clearance_m, least, 2e-3);
        EXPECT_LE(found.clearance_m, least + 1e-12);
    }
}

TEST(Neighbourhood, of_nothing_is_far) {
    EXPECT_EQ(neighbourhood({}, {}, 0.01).clearance_m, 1.0);
}

TEST(Neighbourhood, points_away_from_one_and_to_the_middle_of_two) {
    const auto ball = [](double x) { return scenes::Capsule{{x, 0, 0}, {x, 0, 0}, 0.001}; };
    const std::vector<scenes::Capsule> own = {ball(0.0)}, one = {ball(-0.006)},
                                       two = {ball(-0.006), ball(0.008)};
    EXPECT_NEAR(neighbourhood(own, one, 0.009).way_out_m.x(), 0.005, 1e-12);
    EXPECT_NEAR(neighbourhood(own, two, 0.009).way_out_m.x(), 0.005 - 0.003, 1e-12);
    EXPECT_EQ(neighbourhood(own, one, 0.004).way_out_m.norm(), 0.0);
}

TEST(GiveWay, comes_to_rest_between_two_walls_that_leave_little_room) {
    GiveWay give_way;
    double moved_m = 0.0;
    for (int tick = 0; tick < 3000; ++tick) {
        const double x = give_way.offset_m().x(), left_m = 0.004 + x, right_m = 0.008 - x;
        const double wanted_m = give_way.wanted_clearance_m();
        give_way.step(
            {std::min(left_m, right_m),
             (std::max(0.0, wanted_m - left_m) - std::max(0.0, wanted_m - right_m)) * Vector3d::UnitX()});
        if (tick > 2000) moved_m = std::max(moved_m, std::abs(give_way.offset_m().x() - x));
    }
    EXPECT_NEAR(give_way.offset_m().x(), 0.002, 0.0002);
    EXPECT_LT(moved_m, 1e-9);
}

TEST(GiveWay, keeps_clear_of_what_comes_and_comes_back_when_it_has_gone) {
    GiveWay give_way;
    double least_m = 1.0;
    for (int tick = 0; tick < 6000; ++tick) {
        const double t = 1e-3 * tick, wall_m = 0.02 - 0.03 * std::max(0.0, 1.0 - std::abs(t - 1.5));
        const double clearance_m = give_way.offset_m().x() + wall_m;
        least_m = std::min(least_m, clearance_m);
        give_way.step(
            {clearance_m, std::max(0.0, give_way.wanted_clearance_m() - clearance_m) * Vector3d::UnitX()});
    }
    EXPECT_GT(least_m, 0.002);
    EXPECT_LT(give_way.offset_m().norm(), 1e-4);
    EXPECT_FALSE(GiveWay().is_aside());
}

}  // namespace
}  // namespace atropos::robot
