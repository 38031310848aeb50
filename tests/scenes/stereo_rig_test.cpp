#include "scenes/stereo_rig.hpp"

#include <gtest/gtest.h>

#include "scenes/random_stream.hpp"

namespace atropos::scenes {
namespace {

StereoRig converging_rig() {
    StereoRig rig = parallel_rig(640, 360, 575.0, 0.005);
    rig.left.distortion = {-0.12, 0.05, 1e-3, -2e-3};
    rig.right.distortion = {-0.10, 0.04};
    rig.right.cx_px += 4.0;
    rig.X_RC.linear() = (Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitY()) *
                         Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitX()))
                            .toRotationMatrix();
    rig.X_RC.translation() = Eigen::Vector3d(-0.005, 1e-4, -2e-4);
    return rig;
}

TEST(StereoRig, sees_a_hand_computed_disparity) {
    const StereoRig rig = parallel_rig(640, 360, 575.0, 0.005);
    const Eigen::Vector3d p(0.003, 0.001, 0.1);
    EXPECT_NEAR(rig.project_left(p).x() - rig.project_right(p).x(), 575.0 * 0.005 / 0.1, 1e-10);
    EXPECT_NEAR(rig.project_left(p).y(), rig.project_right(p).y(), 1e-10);
    EXPECT_NEAR(rig.m_per_disparity_px(0.1), 0.01 / (575.0 * 0.005), 1e-15);
}

TEST(StereoRig, projection_matrices_agree_with_projection) {
    StereoRig rig = converging_rig();
    rig.left.distortion = rig.right.distortion = {};
    const Eigen::Vector3d p(0.01, -0.02, 0.12);
    EXPECT_NEAR(((rig.P_left() * p.homogeneous()).hnormalized() - rig.project_left(p)).norm(), 0.0, 1e-10);
    EXPECT_NEAR(((rig.P_right() * p.homogeneous()).hnormalized() - rig.project_right(p)).norm(), 0.0, 1e-10);
}

TEST(StereoRig, unprojects_what_it_projected) {
    RandomStream random(1, "unproject");
    for (const StereoRig& rig : {parallel_rig(640, 360, 575.0, 0.005), converging_rig()})
        for (int i = 0; i < 200; ++i) {
            const Eigen::Vector3d p(random.uniform(-0.03, 0.03), random.uniform(-0.02, 0.02),
                                    random.uniform(0.07, 0.2));
            const auto back = rig.unproject(rig.project_left(p), rig.project_right(p));
            ASSERT_TRUE(back);
            EXPECT_NEAR((*back - p).norm(), 0.0, 1e-10);
        }
}

TEST(StereoRig, refuses_rays_that_do_not_meet_before_the_cameras) {
    const StereoRig rig = parallel_rig(640, 360, 575.0, 0.005);
    EXPECT_FALSE(rig.unproject({320, 180}, {320, 180}));
    EXPECT_FALSE(rig.unproject({300, 180}, {320, 180}));
}

TEST(StereoRig, rectified_rows_agree) {
    RandomStream random(2, "rectify");
    for (const StereoRig& rig : {converging_rig(), rig_preset("scared").rig}) {
        const Rectification r = rig.rectification();
        for (int i = 0; i < 200; ++i) {
            const Eigen::Vector3d p(random.uniform(-0.03, 0.03), random.uniform(-0.02, 0.02),
                                    random.uniform(0.07, 0.2));
            const Eigen::Vector2d left = (r.P1 * (r.R1 * p).homogeneous()).hnormalized();
            // P2 projects points of the rectified *left* frame, as OpenCV's does.
            const Eigen::Vector2d right = (r.P2 * (r.R1 * p).homogeneous()).hnormalized();
            const Eigen::Vector2d right_by_R2 = (r.P1 * (r.R2 * (rig.X_RC * p)).homogeneous()).hnormalized();
            EXPECT_NEAR(left.y(), right_by_R2.y(), 1e-6);
            EXPECT_NEAR((right - right_by_R2).norm(), 0.0, 1e-6);
            const Eigen::Vector4d q = r.Q * Eigen::Vector4d(left.x(), left.y(), left.x() - right.x(), 1.0);
            EXPECT_NEAR((q.hnormalized() - r.R1 * p).norm(), 0.0, 1e-10);
        }
    }
}

TEST(RigPresets, are_all_usable_and_found_by_name) {
    for (const RigPreset& preset : rig_presets()) {
        EXPECT_EQ(&rig_preset(preset.name), &preset);
        EXPECT_GT(preset.rig.left.fx_px, 0.0);
        EXPECT_GT(preset.rig.baseline_m(), 0.003);
        EXPECT_FALSE(preset.source.empty());
        const Eigen::Vector2d px = preset.rig.project_left({0, 0, preset.working_distance_m});
        EXPECT_TRUE(preset.rig.left.contains(px));
    }
    EXPECT_THROW(rig_preset("nonesuch"), std::invalid_argument);
}

}  // namespace
}  // namespace atropos::scenes
