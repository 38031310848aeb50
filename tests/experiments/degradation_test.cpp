#include "experiments/degradation.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace atropos::experiments {
namespace {

tracker::StereoFrame gray_frame(int index, double time_s) {
    tracker::StereoFrame frame;
    frame.index = index;
    frame.capture_time_s = time_s;
    frame.left = cv::Mat(120, 160, CV_8U, cv::Scalar(100));
    frame.right = cv::Mat(120, 160, CV_8U, cv::Scalar(100));
    frame.tips[0] = tracker::MeasuredTip{{0.01, 0.0, 0.1}, tracker::MeasuredTip::Kind::kHeld};
    return frame;
}

TEST(Degradation, of_nothing_leaves_frame_and_rig_as_they_are) {
    tracker::StereoFrame frame = gray_frame(3, 0.1);
    const unsigned char* pixels = frame.left.data;
    degrade(frame, {}, 1);
    EXPECT_EQ(frame.left.data, pixels) << "not even copied";
    const scenes::StereoRig rig = scenes::parallel_rig(160, 120, 140.0, 0.005);
    EXPECT_TRUE(degraded(rig, {}).X_RC.isApprox(rig.X_RC, 0.0));
}

TEST(Degradation, adds_white_noise_of_its_own_to_each_frame_and_eye) {
    Degradation d;
    d.noise_levels = 8.0;
    tracker::StereoFrame one = gray_frame(1, 0.0), again = gray_frame(1, 0.0), two = gray_frame(2, 0.0);
    degrade(one, d, 5);
    degrade(again, d, 5);
    degrade(two, d, 5);
    cv::Scalar mean, sigma;
    cv::meanStdDev(one.left, mean, sigma);
    EXPECT_NEAR(mean[0], 100.0, 0.3);  // five standard errors of 19200 pixels
    EXPECT_NEAR(sigma[0], 8.0, 0.25);
    EXPECT_EQ(cv::norm(one.left, again.left, cv::NORM_INF), 0.0);
    EXPECT_GT(cv::norm(one.left, one.right, cv::NORM_INF), 0.0);
    EXPECT_GT(cv::norm(one.left, two.left, cv::NORM_INF), 0.0);
}

TEST(Degradation, blurs_and_flattens_by_what_it_says) {
    tracker::StereoFrame frame = gray_frame(0, 0.0);
    frame.left.colRange(80, 160).setTo(cv::Scalar(200));
    Degradation d;
    d.contrast_loss = 0.4;
    tracker::StereoFrame flat = frame;
    degrade(flat, d, 1);
    EXPECT_NEAR(flat.left.at<uchar>(60, 120) - flat.left.at<uchar>(60, 40), 60, 1);
    EXPECT_EQ(frame.left.at<uchar>(60, 120), 200) << "the caller's picture is its own";
    d = {};
    d.blur_px = 2.0;
    degrade(frame, d, 1);
    // An edge under a Gaussian: its normal distribution function, pixel centres at +-0.5.
    for (const int u : {76, 79, 80, 82})
        EXPECT_NEAR(frame.left.at<uchar>(60, u),
                    100.0 + 50.0 * (1.0 + std::erf((u - 79.5) / 2.0 / std::sqrt(2.0))), 1.5);
}

TEST(Degradation, moves_the_measured_ends_by_the_same_offset_in_all_frames) {
    Degradation d;
    d.tip_error_mm = 2.0;
    tracker::StereoFrame one = gray_frame(1, 0.0), nine = gray_frame(9, 0.3);
    degrade(one, d, 5);
    degrade(nine, d, 5);
    EXPECT_EQ(one.tips[0]->p_C, nine.tips[0]->p_C);
    EXPECT_FALSE(one.tips[1]);
    double square = 0.0;
    for (std::uint64_t seed = 0; seed < 2000; ++seed) {
        tracker::StereoFrame frame = gray_frame(1, 0.0);
        frame.left = frame.right = cv::Mat(1, 1, CV_8U, cv::Scalar(0));
        degrade(frame, d, seed);
        square += (frame.tips[0]->p_C - Eigen::Vector3d(0.01, 0.0, 0.1)).squaredNorm() / 6000.0;
    }
    EXPECT_NEAR(1e3 * std::sqrt(square), 2.0, 0.1);
}

TEST(Degradation, turns_the_right_camera_about_the_vertical) {
    const scenes::StereoRig rig = scenes::parallel_rig(160, 120, 140.0, 0.005);
    Degradation d;
    d.calibration_error_deg = 1.0;
    const scenes::StereoRig wrong = degraded(rig, d);
    const Eigen::Vector3d p(0.0, 0.0, 0.1);
    EXPECT_EQ(wrong.project_left(p), rig.project_left(p));
    const double focal = 140.0, before = std::atan2(-0.005, 0.1), turned = before + std::numbers::pi / 180.0;
    EXPECT_NEAR(wrong.project_right(p).x() - rig.right.cx_px, focal * std::tan(turned), 0.02);
}

TEST(Degradation, carries_a_bar_across_once_a_second) {
    Degradation d;
    d.occlusion_px = 20.0;
    const auto hidden = [&](double time_s) {
        tracker::StereoFrame frame = gray_frame(0, time_s);
        for (int u = 0; u < 160; u += 2) frame.left.col(u).setTo(cv::Scalar(50));
        degrade(frame, d, 1);
        int flat = 0;
        for (int u = 1; u < 160; ++u)
            flat += frame.left.at<uchar>(5, u) == frame.left.at<uchar>(5, u - 1) ? 1 : 0;
        return flat;
    };
    EXPECT_EQ(hidden(0.0), 0);
    EXPECT_EQ(hidden(0.5), 19);
    EXPECT_EQ(hidden(1.5), 19);
}

}  // namespace
}  // namespace atropos::experiments
