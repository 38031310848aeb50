#include "tracker/path_joiner.hpp"

#include <gtest/gtest.h>

namespace atropos::tracker {
namespace {

RidgePointMap empty_map() {
    RidgePointMap map;
    map.width = map.height = 200;
    map.at_pixel.assign(200 * 200, RidgePointMap::kNone);
    return map;
}

/// A straight piece of points 1 px apart.
ImagePath piece(Eigen::Vector2d from, const Eigen::Vector2d& to) {
    ImagePath path;
    const Eigen::Vector2d along = (to - from).normalized();
    for (int i = 0; i <= static_cast<int>((to - from).norm()); ++i)
        path.points.push_back({from + i * along, along, 10.0});
    return path;
}

/// Two lines that cross at (100, 100), the crossing itself missing.
std::vector<ImagePath> crossing() {
    return {piece({40, 100}, {95, 100}), piece({105, 100}, {160, 100}), piece({100, 40}, {100, 95}),
            piece({100, 105}, {100, 160})};
}

TEST(JoinPieces, runs_straight_through_a_crossing) {
    const std::vector<ImagePath> paths = join_pieces(crossing(), empty_map(), {});
    ASSERT_EQ(paths.size(), 2u);
    for (const ImagePath& path : paths) {
        EXPECT_GT((path.points.front().px - path.points.back().px).norm(), 119.0);
        EXPECT_EQ(path.joins.size(), 1u);
    }
}

TEST(JoinPieces, joins_as_it_is_told_to) {
    JoinWishes wishes;
    wishes.wanted.push_back({{95, 100}, {100, 105}});
    const std::vector<ImagePath> paths = join_pieces(crossing(), empty_map(), {}, wishes);
    ASSERT_EQ(paths.size(), 3u);  // the others' bend is too dear
    EXPECT_EQ(paths[0].joins.size(), 1u);
    EXPECT_NEAR((paths[0].points.front().px - paths[0].points.back().px).norm(), 84.9, 0.2);
}

TEST(JoinPieces, leaves_a_forbidden_join_out_either_way_around) {
    JoinWishes wishes;
    wishes.forbidden.push_back({{105, 100}, {95, 100}});
    EXPECT_EQ(join_pieces(crossing(), empty_map(), {}, wishes).size(), 3u);
}

TEST(JoinPieces, bridges_no_gap_that_something_hides) {
    RidgePointMap map = empty_map();
    for (int v = 0; v < map.height; ++v)
        map.at_pixel[static_cast<std::size_t>(v * map.width + 100)] = RidgePointMap::kHidden;
    const std::vector<ImagePath> pieces{piece({40, 100}, {95, 100}), piece({105, 100}, {160, 100})};
    EXPECT_EQ(join_pieces(pieces, map, {}).size(), 2u);
    EXPECT_EQ(join_pieces(pieces, empty_map(), {}).size(), 1u);
}

TEST(CutPiece, makes_two_ends_of_one_piece) {
    std::vector<ImagePath> pieces{piece({40, 100}, {160, 100})};
    const auto cut = cut_piece(pieces, {100, 101});
    ASSERT_TRUE(cut);
    ASSERT_EQ(pieces.size(), 2u);
    EXPECT_EQ(pieces[0].points.back().px, cut->from);
    EXPECT_EQ(pieces[1].points.front().px, cut->to);
    EXPECT_FALSE(cut_piece(pieces, {100, 150}));
}

}  // namespace
}  // namespace atropos::tracker
