#include "tracker/ground_depth.hpp"

#include <gtest/gtest.h>

#include "tests/support/background.hpp"
#include "tests/support/synthetic_sequence.hpp"

namespace atropos::tracker {
namespace {

struct Eyes {
    scenes::StereoRig rig = scenes::parallel_rig(640, 360, 575.0, 0.005);
    std::array<cv::Mat1b, 2> image;
    std::array<RidgePointMap, 2> map;

    explicit Eyes(const support::BackgroundOptions& wall) {
        const auto painted = support::paint_background(rig, wall);
        painted.first.convertTo(image[0], CV_8U);
        painted.second.convertTo(image[1], CV_8U);
        for (RidgePointMap& m : map) {
            m.width = rig.left.width_px;
            m.height = rig.left.height_px;
            m.at_pixel.assign(static_cast<std::size_t>(m.width * m.height), RidgePointMap::kNone);
        }
    }
    ImageView view(std::size_t eye) const {
        return {image[eye].data, static_cast<std::ptrdiff_t>(image[eye].step), 1, image[eye].cols,
                image[eye].rows};
    }
    void look(GroundDepth& ground) const {
        const ImageView left = view(0), right = view(1);
        ground.look({left, map[0], {}}, {right, map[1], {}}, 0.6, 40.0);
    }
};

TEST(GroundDepth, measures_how_far_a_leaning_textured_wall_is) {
    const support::BackgroundOptions wall{.seed = 3, .depth_m = 0.110, .vessels = 0};
    const Eyes eyes(wall);
    GroundDepth ground(eyes.rig);
    eyes.look(ground);
    const RectifiedView view(eyes.rig);
    for (const Eigen::Vector2d& px : {Eigen::Vector2d(160, 100), {320, 180}, {500, 100}, {480, 260}}) {
        // z = depth + slope_x x + slope_y y on the wall, along the pixel's ray.
        const Eigen::Vector2d n = eyes.rig.left.normalised(px);
        const double z = wall.depth_m / (1.0 - wall.slope_x * n.x() - wall.slope_y * n.y());
        const auto d = ground.disparity_px(view.rectified(px, 0));
        ASSERT_TRUE(d) << px.transpose();
        EXPECT_NEAR(*d, view.disparity_px(z), 0.6) << px.transpose();
    }
}

TEST(GroundDepth, knows_nothing_of_a_wall_without_texture) {
    const Eyes eyes({.clutter = false});
    GroundDepth ground(eyes.rig);
    eyes.look(ground);
    EXPECT_FALSE(ground.disparity_px({0.0, 0.0}));
}

TEST(GroundDepth, leaves_out_what_is_hidden) {
    Eyes eyes({.seed = 3, .depth_m = 0.110, .vessels = 0});
    for (RidgePointMap& m : eyes.map) std::fill(m.at_pixel.begin(), m.at_pixel.end(), RidgePointMap::kHidden);
    GroundDepth ground(eyes.rig);
    eyes.look(ground);
    EXPECT_FALSE(ground.disparity_px({0.0, 0.0}));
}

}  // namespace
}  // namespace atropos::tracker
