#include "render/sensor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "render/block_compression.hpp"
#include "render/calibration_error.hpp"
#include "render_scenes.hpp"
#include "scenes/random_stream.hpp"

namespace atropos::render {
namespace {

StereoFrame even_frame(float value) {
    StereoFrame frame;
    for (EyeFrame* eye : {&frame.left, &frame.right})
        eye->linear = cv::Mat(360, 640, CV_32FC3, cv::Scalar::all(value));
    return frame;
}

const scenes::StereoRig& rig() {
    return scenes::rig_preset("paper").rig;
}

// Tissue-like: fine structure in brightness, slow changes of colour.
cv::Mat busy_picture(cv::Size size) {
    cv::Mat picture(size, CV_8UC3);
    scenes::RandomStream random(3, "busy picture");
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
            const double light = 110.0 + 40.0 * std::sin(0.31 * x + 0.2 * y) + random.uniform(-25.0, 25.0);
            const double hue = 30.0 * std::sin(0.07 * x) * std::cos(0.05 * y);
            picture.at<cv::Vec3b>(y, x) = {cv::saturate_cast<uchar>(light - hue),
                                           cv::saturate_cast<uchar>(light),
                                           cv::saturate_cast<uchar>(light + hue)};
        }
    return picture;
}

TEST(BlockCompression, leaves_what_libjpeg_leaves) {
    for (const int quality : {30, 75, 92}) {
        for (const cv::Size size : {cv::Size(160, 96), cv::Size(101, 67), cv::Size(1, 1)}) {
            const cv::Mat picture = busy_picture(size);
            std::vector<std::uint8_t> bytes;
            cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
            const cv::Mat theirs = cv::imdecode(bytes, cv::IMREAD_COLOR), ours = compressed(picture, quality);
            const double mean =
                cv::norm(ours, theirs, cv::NORM_L1) / static_cast<double>(3 * picture.total());
            std::printf("quality %d, %dx%d: mean difference %.2f, change by compression %.2f\n", quality,
                        size.width, size.height, mean,
                        cv::norm(ours, picture, cv::NORM_L1) / static_cast<double>(3 * picture.total()));
            // libjpeg rounds inside its steps too: a coefficient near a half may fall to the other side.
            EXPECT_LE(mean, 1.1);
        }
    }
    EXPECT_THROW(compressed(busy_picture({8, 8}), 0), std::invalid_argument);
    EXPECT_THROW(compressed(cv::Mat(), 50), std::invalid_argument);
}

TEST(Sensor, codes_light_as_srgb_when_ideal) {
    const Sensor sensor(sensor_preset("ideal"), rig(), 1);
    for (const float v : {0.0f, 0.002f, 0.05f, 0.18f, 0.5f, 1.0f, 7.0f}) {
        const double coded =
            v <= 0.0031308f ? 12.92 * v : 1.055 * std::pow(std::min(v, 1.0f), 1.0 / 2.4) - 0.055;
        EXPECT_NEAR(sensor.develop(even_frame(v), 0).left.at<cv::Vec3b>(100, 100)[1], 255.0 * coded, 0.75)
            << v;
    }
}

TEST(Sensor, has_the_noise_it_is_asked_for) {
    SensorOptions options;
    options.read_noise = 0.006;
    options.shot_noise = 9.0;
    const Sensor sensor(options, rig(), 1);
    const float light = 0.4f;
    const StereoImages images = sensor.develop(even_frame(light), 3);
    double sum = 0.0, sum2 = 0.0;
    for (int y = 0; y < 360; ++y) {
        for (int x = 0; x < 640; ++x) {
            const double coded = images.left.at<cv::Vec3b>(y, x)[0] / 255.0;
            const double value = std::pow((coded + 0.055) / 1.055, 2.4);
            sum += value;
            sum2 += value * value;
        }
    }
    const double n = 640.0 * 360.0, mean = sum / n, sigma = std::sqrt(sum2 / n - mean * mean);
    EXPECT_NEAR(mean, light, 5e-4);
    EXPECT_NEAR(sigma, 0.006 * std::sqrt(1.0 + 9.0 * light), 0.0005);
}

TEST(Sensor, repeats_a_frame_and_changes_between_frames_eyes_and_seeds) {
    const SensorOptions options = sensor_preset("realistic");
    const StereoFrame frame = even_frame(0.2f);
    const StereoImages first = Sensor(options, rig(), 1).develop(frame, 5);
    EXPECT_TRUE(same_bytes(first.left, Sensor(options, rig(), 1).develop(frame, 5).left));
    EXPECT_FALSE(same_bytes(first.left, first.right));
    EXPECT_FALSE(same_bytes(first.left, Sensor(options, rig(), 1).develop(frame, 6).left));
    EXPECT_FALSE(same_bytes(first.left, Sensor(options, rig(), 2).develop(frame, 5).left));
}

TEST(Sensor, darkens_corners_by_the_cosine_law) {
    SensorOptions options;
    options.vignetting = 1.0;
    const StereoImages images = Sensor(options, rig(), 1).develop(even_frame(0.5f), 0);
    const double cos = rig().left.ray(Eigen::Vector2d(0.0, 0.0)).z(), v = 0.5 * std::pow(cos, 4.0);
    EXPECT_NEAR(images.left.at<cv::Vec3b>(0, 0)[1], 255.0 * (1.055 * std::pow(v, 1.0 / 2.4) - 0.055), 1.0);
}

TEST(Sensor, brings_dark_scenes_up_with_gain) {
    SensorOptions options;
    options.auto_gain = true;
    const Sensor sensor(options, rig(), 1);
    EXPECT_EQ(sensor.develop(even_frame(0.08f), 0).left.at<cv::Vec3b>(9, 9),
              sensor.develop(even_frame(0.24f), 0).left.at<cv::Vec3b>(9, 9));
}

TEST(Sensor, exposes_the_left_eye_early_and_averages_what_moves) {
    SensorOptions options;
    options.exposure_time_s = 0.01;
    options.right_eye_delay_s = 0.004;
    const Sensor sensor(options, rig(), 1);
    const std::vector<double> left_s = sensor.exposure_times_s(1.0, 0),
                              right_s = sensor.exposure_times_s(1.0, 1);
    ASSERT_EQ(left_s.size(), 4u);
    EXPECT_NEAR(right_s.front(), 0.99125, 1e-12);
    EXPECT_LT(right_s.back(), 1.0);
    EXPECT_NEAR(right_s.front() - left_s.front(), 0.004, 1e-12);
    StereoFrame dark = even_frame(0.1f), bright = even_frame(0.3f);
    for (StereoFrame* f : {&dark, &bright})
        f->left.coverage = f->right.coverage = cv::Mat::zeros(360, 640, CV_32F);
    const std::vector<StereoFrame> frames = {dark, bright};
    EXPECT_NEAR(mean_exposure(frames).left.linear.at<cv::Vec3f>(5, 5)[0], 0.2f, 1e-6);
}

TEST(CalibrationError, stays_small_and_repeats) {
    const scenes::StereoRig a = told_rig(rig(), {}, 7), b = told_rig(rig(), {}, 7),
                            other = told_rig(rig(), {}, 8);
    EXPECT_EQ(a.left.cx_px, b.left.cx_px);
    EXPECT_NE(a.left.cx_px, other.left.cx_px);
    const Eigen::Vector3d p(0.01, 0.005, 0.1);
    EXPECT_LT((a.project_right(p) - rig().project_right(p)).norm(), 3.0);
    EXPECT_GT((a.project_right(p) - rig().project_right(p)).norm(), 0.01);
}

TEST(Sensor, refuses_options_out_of_range) {
    SensorOptions options;
    options.vignetting = 2.0;
    EXPECT_THROW(Sensor(options, rig(), 1), std::invalid_argument);
    EXPECT_THROW(sensor_preset("perfect"), std::invalid_argument);
}

}  // namespace
}  // namespace atropos::render
