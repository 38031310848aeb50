#include "scenes/camera.hpp"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>

#include "scenes/random_stream.hpp"

namespace atropos::scenes {
namespace {

Camera distorted_camera() {
    return {640, 360, 575.0, 560.0, 318.3, 181.7, {-0.12, 0.05, 1e-3, -2e-3, 0.01}};
}

TEST(Camera, projects_a_hand_computed_point) {
    const Camera camera{640, 360, 500.0, 400.0, 320.0, 180.0, {}};
    const Eigen::Vector2d px = camera.project({0.01, -0.02, 0.1});
    EXPECT_DOUBLE_EQ(px.x(), 370.0);
    EXPECT_DOUBLE_EQ(px.y(), 100.0);
}

TEST(Camera, agrees_with_opencv_under_every_distortion_term) {
    Camera camera = distorted_camera();
    camera.distortion = {-0.12, 0.05, 1e-3, -2e-3, 0.01, 0.02, -0.01, 0.004};
    RandomStream random(7, "camera-test");
    std::vector<cv::Point3d> points;
    for (int i = 0; i < 500; ++i)
        points.emplace_back(random.uniform(-0.05, 0.05), random.uniform(-0.03, 0.03),
                            random.uniform(0.07, 0.2));
    const cv::Matx33d K(camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1);
    const cv::Mat D(1, 8, CV_64F, camera.distortion.data());
    std::vector<cv::Point2d> expected;
    cv::projectPoints(points, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), K, D, expected);
    for (size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector2d px = camera.project({points[i].x, points[i].y, points[i].z});
        EXPECT_NEAR(px.x(), expected[i].x, 1e-9);
        EXPECT_NEAR(px.y(), expected[i].y, 1e-9);
    }
}

TEST(Camera, undoes_its_own_distortion) {
    const Camera camera = distorted_camera();
    for (double u = 0; u < 640; u += 40)
        for (double v = 0; v < 360; v += 40) {
            const Eigen::Vector2d xn = camera.normalised({u, v});
            const Eigen::Vector2d back = camera.project(Eigen::Vector3d(0.1 * xn.homogeneous()));
            EXPECT_NEAR((back - Eigen::Vector2d(u, v)).norm(), 0.0, 1e-9);
        }
}

TEST(Camera, jacobian_agrees_with_differences) {
    const Camera camera = distorted_camera();
    const Eigen::Vector3d p(0.021, -0.013, 0.094);
    Eigen::Matrix<double, 2, 3> J;
    EXPECT_NEAR((camera.project(p, J) - camera.project(p)).norm(), 0.0, 1e-10);
    for (int axis = 0; axis < 3; ++axis) {
        const double h = 1e-7;
        const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(axis);
        const Eigen::Vector2d numeric = (camera.project(p + step) - camera.project(p - step)) / (2 * h);
        EXPECT_NEAR((J.col(axis) - numeric).norm(), 0.0, 1e-4 * numeric.norm() + 1e-4);
    }
}

TEST(Camera, keeps_pixel_centres_at_integers_when_scaled) {
    const Camera full{1920, 1080, 1725, 1725, 959.5, 539.5, {}};
    const Camera third = full.scaled(1.0 / 3.0);
    EXPECT_EQ(third.width_px, 640);
    EXPECT_NEAR(third.cx_px, 319.5, 1e-12);
    EXPECT_NEAR(third.fx_px, 575.0, 1e-12);
}

}  // namespace
}  // namespace atropos::scenes
