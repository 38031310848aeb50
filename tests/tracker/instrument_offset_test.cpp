#include "tracker/instrument_offset.hpp"

#include <gtest/gtest.h>

#include "scenes/random_stream.hpp"
#include "tests/support/background.hpp"

namespace atropos::tracker {
namespace {

/// A pair of blades on a shaft that comes from below and the camera's side, tip near the middle of the view.
std::vector<scenes::Capsule> scissors_C(scenes::RandomStream& random) {
    const Eigen::Vector3d joint(random.uniform(-0.008, 0.008), random.uniform(0.0, 0.008),
                                random.uniform(0.09, 0.11));
    const double turn = random.uniform(-0.6, 0.6);
    const Eigen::Vector3d up(std::sin(turn), -std::cos(turn), random.uniform(0.0, 0.3));
    const Eigen::Vector3d side(std::cos(turn), std::sin(turn), 0.0);
    return {{joint, joint + 0.010 * (up + 0.25 * side), 0.0012},
            {joint, joint + 0.010 * (up - 0.25 * side), 0.0012},
            {joint, joint + 0.06 * Eigen::Vector3d(-0.3 * std::sin(turn), 0.9, -0.5).normalized(), 0.004}};
}

void draw(const scenes::StereoRig& rig, bool right, const std::vector<scenes::Capsule>& capsules_C,
          const cv::Mat1f& ground, scenes::RandomStream& random, cv::Mat& out) {
    const scenes::Camera& camera = right ? rig.right : rig.left;
    const Eigen::Isometry3d X_CE = right ? rig.X_RC.inverse() : Eigen::Isometry3d::Identity();
    out.create(ground.size(), CV_8UC1);
    for (int v = 0; v < ground.rows; ++v)
        for (int u = 0; u < ground.cols; ++u) {
            double level = 0.0;
            for (int sub = 0; sub < 4; ++sub) {
                const Eigen::Vector3d ray =
                    X_CE.linear() * camera.ray({u - 0.25 + 0.5 * (sub & 1), v - 0.25 + 0.5 * (sub >> 1)});
                const Eigen::Vector3d eye = X_CE.translation();
                double here = static_cast<double>(ground(v, u));
                for (const scenes::Capsule& capsule : capsules_C) {
                    const double away =
                        scenes::segment_distance(eye, eye + 0.3 * ray, capsule.a, capsule.b).distance_m;
                    if (away < capsule.radius_m) here = 90.0 + 120.0 * (1.0 - away / capsule.radius_m);
                }
                level += 0.25 * here;
            }
            out.at<unsigned char>(v, u) =
                static_cast<unsigned char>(std::clamp(level + random.normal(0.0, 3.0), 0.0, 255.0));
        }
}

TEST(InstrumentOffset, finds_scissors_two_millimetres_from_where_they_were_measured) {
    const scenes::StereoRig rig = scenes::parallel_rig(640, 360, 575.0, 0.005);
    int near = 0;
    const int poses = 8;
    for (int i = 0; i < poses; ++i) {
        scenes::RandomStream random(static_cast<std::uint64_t>(200 + i), "scissors");
        const auto ground = support::paint_background(
            rig, {.seed = static_cast<std::uint64_t>(i), .depth_m = 0.13, .vessels = 3});
        const std::vector<scenes::Capsule> measured_C = scissors_C(random);
        const Eigen::Vector3d offset_C =
            0.0019 * Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
        std::vector<scenes::Capsule> true_C = measured_C;
        for (scenes::Capsule& capsule : true_C) {
            capsule.a += offset_C;
            capsule.b += offset_C;
        }
        StereoFrame frame;
        draw(rig, false, true_C, ground.first, random, frame.left);
        draw(rig, true, true_C, ground.second, random, frame.right);
        const InstrumentOffset found = find_instrument_offset(frame, rig, measured_C, {});
        EXPECT_TRUE(found.found) << "pose " << i << " support " << found.support;
        const Eigen::Vector3d error = found.offset_C - offset_C;
        const bool close = error.head<2>().norm() < 0.00035 && std::abs(error.z()) < 0.0015;
        const bool honest = error.dot(found.covariance.ldlt().solve(error)) < 11.3;  // 99 % of chi squared, 3
        near += close && honest;
    }
    // One pose of eight slides along its own blades to another set of edges.
    EXPECT_GE(near, poses - 1);
}

TEST(InstrumentOffset, is_not_found_where_there_is_none) {
    const scenes::StereoRig rig = scenes::parallel_rig(640, 360, 575.0, 0.005);
    scenes::RandomStream random(300, "scissors");
    StereoFrame frame;
    frame.left = cv::Mat(360, 640, CV_8UC1, cv::Scalar(120));
    frame.right = frame.left.clone();
    EXPECT_FALSE(find_instrument_offset(frame, rig, scissors_C(random), {}).found);
    EXPECT_FALSE(find_instrument_offset(frame, rig, {}, {}).found);
}

}  // namespace
}  // namespace atropos::tracker
