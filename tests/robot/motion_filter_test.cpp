#include "robot/motion_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "scenes/random_stream.hpp"

namespace atropos::robot {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kFrame_s = 1.0 / 30.0, kAhead_s = 0.15, kNoise_m = 5e-5;

// Two grips moving against one another as briskly as in the fast scene, and a point that gives with them.
Vector3d drive(double t) {
    return {0.006 * std::sin(5.8 * t), 0.008 * std::sin(4.2 * t + 1.0), 0.006 * std::sin(7.4 * t + 2.0)};
}

Vector3d point(double t) {
    Matrix3d R;
    R << 0.1, 0.3, 0.0, -0.2, 0.1, 0.4, 0.0, -0.3, 0.2;
    return Vector3d(0.001, 0.002, -0.015) + R * drive(t);
}

// RMS error of the place 0.15 s ahead, the drive then being known; from the fourth second on.
double error_ahead_m(double response_sigma) {
    MotionFilter::Options options{0.04, 0.3, 0.01};
    options.response_sigma = response_sigma;
    MotionFilter filter(options);
    scenes::RandomStream noise(1, "test.motion_filter");
    const Matrix3d R = kNoise_m * kNoise_m * Matrix3d::Identity();
    double sum = 0.0;
    int count = 0;
    for (int frame = 0; frame < 300; ++frame) {
        const double t = frame * kFrame_s;
        const Vector3d seen = point(t) + kNoise_m * Vector3d(noise.normal(), noise.normal(), noise.normal());
        if (frame == 0)
            filter.start(t, seen, R);
        else
            filter.update(t, seen, R, drive(t));
        if (t < 4.0) continue;
        const double then = t + kAhead_s;
        sum += (filter.at(then, drive(then)).p - point(then)).squaredNorm();
        ++count;
    }
    return std::sqrt(sum / count);
}

TEST(MotionFilter, learns_how_a_point_gives_to_what_drives_it) {
    const double without = error_ahead_m(0.0), with = error_ahead_m(0.4);
    std::printf("0.15 s ahead: %.2f mm without the response, %.2f mm with it\n", 1e3 * without, 1e3 * with);
    EXPECT_LT(with, 0.3 * without);
}

}  // namespace
}  // namespace atropos::robot
