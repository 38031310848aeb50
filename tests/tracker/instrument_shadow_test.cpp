#include "tracker/instrument_shadow.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace atropos::tracker {
namespace {

/// A ridge point in every pixel.
RidgePointMap full_map() {
    RidgePointMap map;
    map.width = 200;
    map.height = 100;
    for (int i = 0; i < map.width * map.height; ++i) {
        map.points.push_back({Eigen::Vector2d(i % map.width, i / map.width)});
        map.at_pixel.push_back(i);
    }
    return map;
}

const scenes::Camera kCamera{200, 100, 500.0, 500.0, 100.0, 50.0};

TEST(HideInstruments, takes_away_what_a_capsule_covers_and_its_margin) {
    RidgePointMap map = full_map();
    // 10 px in radius about the image's middle.
    const std::vector<scenes::Capsule> instruments{{{0.0, 0.0, 0.1}, {0.0, 0.0, 0.1}, 0.002}};
    hide_instruments(instruments, kCamera, Eigen::Isometry3d::Identity(), 3.0, map);
    EXPECT_EQ(map.index(100, 50), RidgePointMap::kHidden);
    EXPECT_EQ(map.index(112, 50), RidgePointMap::kHidden);
    ASSERT_GE(map.index(114, 50), 0);
    EXPECT_EQ(map.points[static_cast<std::size_t>(map.index(114, 50))].px, Eigen::Vector2d(114, 50));
    EXPECT_TRUE(near_hidden(map, {115, 50}, 4.0));
    EXPECT_FALSE(near_hidden(map, {120, 50}, 4.0));
}

TEST(ReachInstruments, takes_a_line_on_through_the_margin_and_leaves_a_free_end) {
    RidgePointMap map = full_map();
    for (int v = 0; v < map.height; ++v)
        for (int u = 100; u < map.width; ++u)
            map.at_pixel[static_cast<std::size_t>(v * map.width + u)] = RidgePointMap::kHidden;
    ImagePath path;
    for (int u = 40; u < 100; ++u) path.points.push_back({{u, 50.0}, {1.0, 0.0}, 10.0});
    reach_instruments(path, map, 3.5);
    EXPECT_EQ(path.points.front().px, Eigen::Vector2d(40, 50));
    EXPECT_NEAR(path.points.back().px.x(), 102.0, 1e-9);
    EXPECT_EQ(path.points.back().strength_levels, 0.0);
}

}  // namespace
}  // namespace atropos::tracker
