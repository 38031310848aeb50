#include "tracker/motion_prediction.hpp"

#include <gtest/gtest.h>

namespace atropos::tracker {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

/// How far the prediction of the next frame goes on from what was found `off_m` beside the last one.
double goes_on_m(double off_m) {
    constexpr double kFrame_s = 1.0 / 30.0;
    MotionPrediction motion{Matrix3Xd::Zero(3, 8)};
    const Matrix3Xd expected = Matrix3Xd::Zero(3, 8);
    Matrix3Xd found = expected, next;
    found.row(0).array() += off_m;
    motion.follow(found, expected, kFrame_s);
    motion.predict(found, {Vector3d::Zero(), Vector3d::Zero()}, kFrame_s, next);
    return (next - found).colwise().norm().maxCoeff();
}

TEST(MotionPrediction, goes_on_by_half_of_what_a_thread_did) {
    EXPECT_NEAR(goes_on_m(0.002), 0.001, 1e-9);
}

TEST(MotionPrediction, does_not_carry_on_a_thread_that_was_found_elsewhere) {
    EXPECT_EQ(goes_on_m(0.015), 0.0);
}

}  // namespace
}  // namespace atropos::tracker
