#include "tracker/cramer_rao_bound.hpp"

#include <gtest/gtest.h>

#include "tests/support/inextensible_curve.hpp"

namespace atropos::tracker {
namespace {

double bound_mm(const scenes::StereoRig& rig, BoundOptions options = {}) {
    const scenes::Polyline truth_C = support::InextensibleCurve({}).at(0.0);
    return 1e3 * cramer_rao_bound(truth_C, rig, {}, options).mean_3d_m;
}

TEST(CramerRaoBound, is_a_tenth_of_a_millimetre_at_the_reference_camera) {
    const double mm = bound_mm(scenes::parallel_rig(640, 360, 575.0, 0.005));
    RecordProperty("bound_mm", std::to_string(mm));
    EXPECT_GT(mm, 0.05);
    EXPECT_LT(mm, 0.16);
}

TEST(CramerRaoBound, falls_with_resolution_and_baseline_and_grows_with_noise) {
    const double usual = bound_mm(scenes::parallel_rig(640, 360, 575.0, 0.005));
    EXPECT_LT(bound_mm(scenes::parallel_rig(1920, 1080, 1725.0, 0.005)), 0.5 * usual);
    EXPECT_LT(bound_mm(scenes::parallel_rig(640, 360, 575.0, 0.010)), 0.8 * usual);
    EXPECT_GT(bound_mm(scenes::parallel_rig(640, 360, 575.0, 0.005), {.contrast_levels = 14.0}), 2.0 * usual);
}

}  // namespace
}  // namespace atropos::tracker
