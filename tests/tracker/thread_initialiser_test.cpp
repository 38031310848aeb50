#include "tracker/thread_initialiser.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "scenes/random_stream.hpp"

namespace atropos::tracker {
namespace {

using Eigen::Vector3d;

constexpr double kChord_m = 0.045;

/// A thread between two ends on a line along the baseline, that hangs down by a sag as long as its length
/// asks for and, by `angle_rad`, away from the camera.
scenes::Polyline hanging_thread(double length_m, double angle_rad) {
    scenes::Polyline thread;
    const Vector3d direction(0.0, std::cos(angle_rad), std::sin(angle_rad));
    for (double sag_m = 0.0; thread.points.empty() || thread.length_m() < length_m; sag_m += 1e-5) {
        thread.points.clear();
        for (int i = 0; i <= 200; ++i) {
            const double u = i / 200.0, bow = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * u);
            thread.points.push_back(Vector3d(kChord_m * (u - 0.5), -0.008, 0.093) +
                                    sag_m * (0.7 * bow + 1.2 * u * (1.0 - u)) * direction);
        }
    }
    return thread;
}

/// The thread, dark over an even ground with noise, in both eyes.
StereoFrame picture_of(const scenes::Polyline& thread, const scenes::StereoRig& rig, std::uint64_t seed) {
    constexpr int kShift = 6;
    StereoFrame frame;
    scenes::RandomStream random(seed, "test.ground");
    for (const bool right : {false, true}) {
        cv::Mat image(rig.left.height_px, rig.left.width_px, CV_8U, cv::Scalar(150));
        std::vector<cv::Point> line;
        for (const Vector3d& p : thread.points) {
            const Eigen::Vector2d px = right ? rig.project_right(p) : rig.project_left(p);
            line.emplace_back(static_cast<int>(std::lround(px.x() * (1 << kShift))),
                              static_cast<int>(std::lround(px.y() * (1 << kShift))));
        }
        cv::polylines(image, line, false, cv::Scalar(60), 2, cv::LINE_AA, kShift);
        for (int v = 0; v < image.rows; ++v)
            for (int u = 0; u < image.cols; ++u)
                image.at<unsigned char>(v, u) =
                    cv::saturate_cast<unsigned char>(image.at<unsigned char>(v, u) + random.normal(0.0, 3.0));
        (right ? frame.right : frame.left) = image;
    }
    frame.tips[0] = MeasuredTip{thread.points.front(), MeasuredTip::Kind::kHeld};
    frame.tips[1] = MeasuredTip{thread.points.back(), MeasuredTip::Kind::kHeld};
    return frame;
}

TEST(InitialCurve, bulges_to_the_side_to_which_a_slack_thread_hangs_and_comes_within_the_width_of_its_ridge) {
    // The cost image is flat over the ridge of a two-pixel line.
    constexpr double kFlat_px = 3.0;
    const scenes::StereoRig rig = scenes::parallel_rig(640, 360, 575.0, 0.005);
    scenes::TrackerConfig config;
    scenes::WorkerPool pool(1);
    for (const double length_m : {0.050, 0.055})
        for (const double angle_deg : {-50.0, -30.0, 0.0, 30.0, 50.0}) {
            config.thread.length_m = length_m;
            const scenes::Polyline thread = hanging_thread(length_m, angle_deg * std::numbers::pi / 180.0);
            const auto found = initial_curve_between_tips(config, rig, picture_of(thread, rig, 7), pool);
            ASSERT_TRUE(found) << angle_deg << " degrees";
            const NurbsCurve curve(config.curve.degree, *found);
            const double wanted_m = thread.point_at(0.5 * length_m).z();
            EXPECT_NEAR(sampled(curve, 101).points[50].z(), wanted_m,
                        kFlat_px * wanted_m * wanted_m / (575.0 * 0.005))
                << 1e3 * length_m << " mm at " << angle_deg << " degrees";
        }
}

}  // namespace
}  // namespace atropos::tracker
