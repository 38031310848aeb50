#include "scenes/polyline.hpp"

#include <gtest/gtest.h>

namespace atropos::scenes {
namespace {

const Polyline kCorner{{{0, 0, 0}, {1, 0, 0}, {1, 2, 0}}};

TEST(Polyline, measures_arc_length) {
    EXPECT_DOUBLE_EQ(kCorner.length_m(), 3.0);
    EXPECT_EQ(kCorner.arc_lengths_m(), (std::vector<double>{0, 1, 3}));
}

TEST(Polyline, finds_points_by_arc_length_and_stops_at_its_ends) {
    EXPECT_EQ(kCorner.point_at(2.0), Eigen::Vector3d(1, 1, 0));
    EXPECT_EQ(kCorner.point_at(-1.0), kCorner.points.front());
    EXPECT_EQ(kCorner.point_at(9.0), kCorner.points.back());
    EXPECT_THROW(Polyline{}.point_at(0), std::invalid_argument);
}

TEST(Polyline, resamples_at_equal_steps) {
    const Polyline p = kCorner.resampled(4);
    ASSERT_EQ(p.points.size(), 4u);
    EXPECT_EQ(p.points[1], Eigen::Vector3d(1, 0, 0));
    EXPECT_EQ(p.points[3], Eigen::Vector3d(1, 2, 0));
}

TEST(Polyline, finds_the_nearest_point) {
    const Polyline::Nearest n = kCorner.nearest({3, 1, 0});
    EXPECT_EQ(n.point, Eigen::Vector3d(1, 1, 0));
    EXPECT_DOUBLE_EQ(n.s_m, 2.0);
    EXPECT_DOUBLE_EQ(n.distance_m, 2.0);
}

}  // namespace
}  // namespace atropos::scenes
