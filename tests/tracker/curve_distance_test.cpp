#include "tracker/curve_distance.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/inextensible_curve.hpp"

namespace atropos::tracker {
namespace {

TEST(CurveDistance, of_parallel_lines_is_their_gap) {
    const scenes::Polyline a{{{0, 0, 0}, {1, 0, 0}}};
    const scenes::Polyline b{{{-1, 0.25, 0}, {2, 0.25, 0}}};
    EXPECT_NEAR(curve_distance(a, b), 0.25, 1e-12);
}

TEST(CurveDistance, of_a_slanted_line_is_the_mean_of_its_distances) {
    const scenes::Polyline a{{{0, 0, 0}, {1, 1, 0}}};
    const scenes::Polyline b{{{0, 0, 0}, {1, 0, 0}}};
    EXPECT_NEAR(curve_distance(a, b), 0.5, 1e-12);
}

TEST(CurveDistance, equals_dense_sampling) {  // eq. 20 and 22
    for (std::uint64_t seed = 0; seed < 2; ++seed) {
        const scenes::Polyline truth = support::InextensibleCurve({.seed = seed}).at(0.0, 30);
        scenes::Polyline moved = support::InextensibleCurve({.seed = seed}).at(15.0, 30);
        const NurbsCurve curve = fit_curve(moved, {.control_points = 8});
        double dense = 0.0;
        const int count = 20000;
        for (int j = 0; j < count; ++j)
            dense += truth.nearest(curve.point((j + 0.5) / count)).distance_m / count;
        EXPECT_NEAR(curve_distance(curve, truth), dense, 1e-9);
    }
}

TEST(CurveDistance, of_polylines_equals_dense_sampling) {  // eq. 21 and 22
    const scenes::StereoRig rig = scenes::parallel_rig(640, 360, 575.0, 0.005);
    const scenes::Polyline truth = support::InextensibleCurve({.seed = 3}).at(0.0, 40);
    const scenes::Polyline moved = support::InextensibleCurve({.seed = 3}).at(12.0, 25);
    double dense = 0.0;
    for (int eye = 0; eye < 2; ++eye) {
        const scenes::Polyline a = image_of(moved, rig, eye);
        const scenes::Polyline b = image_of(truth, rig, eye);
        const int count = 20000;
        for (int j = 0; j < count; ++j)
            dense += 0.5 * b.nearest(a.point_at((j + 0.5) / count * a.length_m())).distance_m / count;
    }
    EXPECT_NEAR(image_distance_px(moved, truth, rig), dense, 1e-7);
}

TEST(CurveDistance, is_blind_to_a_missing_half_where_the_symmetric_one_is_not) {
    const scenes::Polyline whole{{{0, 0, 0}, {1, 0, 0}}};
    const scenes::Polyline half{{{0, 0, 0}, {0.5, 0, 0}}};
    EXPECT_NEAR(curve_distance(half, whole), 0.0, 1e-12);
    EXPECT_NEAR(symmetric_curve_distance(half, whole), 0.5 * 0.125, 1e-10);
    EXPECT_NEAR(arc_length_distance(half, whole).middle_m, 0.25, 1e-12);
}

}  // namespace
}  // namespace atropos::tracker
