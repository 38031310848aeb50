#include "tracker/curve_slide.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tracker/nurbs_curve.hpp"

namespace atropos::tracker {
namespace {

constexpr double kRadius_m = 0.01;

/// An arc of `turn_rad` about the optical axis.
Eigen::Matrix3Xd arc(double turn_rad, int K) {
    scenes::Polyline line;
    for (int i = 0; i <= 400; ++i) {
        const double a = turn_rad * i / 400.0;
        line.points.emplace_back(kRadius_m * std::cos(a), kRadius_m * std::sin(a), 0.1);
    }
    const NurbsCurve curve = fit_curve(line, {.degree = 3, .control_points = K, .length_weight = 1.0});
    Eigen::Matrix3Xd Q(3, K);
    for (int k = 0; k < K; ++k) Q.col(k) = curve.control_points()[static_cast<std::size_t>(k)];
    return Q;
}

std::array<std::optional<EndPrior>, 2> ends_of(const Eigen::Matrix3Xd& Q, double along_first_m,
                                               double along_last_m) {
    const int last = static_cast<int>(Q.cols()) - 1;
    std::array<std::optional<EndPrior>, 2> ends;
    ends[0] = EndPrior{.p_C = Q.col(0) + along_first_m * (Q.col(1) - Q.col(0)).normalized()};
    ends[1] = EndPrior{.p_C = Q.col(last) + along_last_m * (Q.col(last) - Q.col(last - 1)).normalized()};
    return ends;
}

TEST(CurveInterpolation, carries_a_curve_over_to_more_control_points) {
    const CubicBasis few(16), many(24);
    const Eigen::Matrix3Xd Q = arc(4.0, 16);
    const Eigen::Matrix3Xd more = CurveInterpolation(many).carried_over(few, Q);
    for (double u = 0.0; u <= 1.0; u += 0.01)
        EXPECT_LT((many.at(u).point(more) - few.at(u).point(Q)).norm(), 3e-6) << u;
}

TEST(CurveInterpolation, slides_an_arc_along_itself_by_far_more_than_its_tangent_goes) {
    const double turn_rad = 4.0, by_rad = 0.3;
    const CubicBasis basis(16);
    const Eigen::Matrix3Xd Q = arc(turn_rad, 16);
    const Eigen::Matrix3Xd slid = CurveInterpolation(basis).carried_over(basis, Q, by_rad / turn_rad);
    for (double u = 0.0; u < 0.85; u += 0.01) {
        const double a = turn_rad * u + by_rad;
        const Eigen::Vector3d expected(kRadius_m * std::cos(a), kRadius_m * std::sin(a), 0.1);
        EXPECT_LT((basis.at(u).point(slid) - expected).norm(), 5e-5) << u;
    }
}

TEST(WantedSlide, is_what_both_ends_ask_for_by_their_information) {
    const Eigen::Matrix3Xd Q = arc(2.0, 16);
    auto ends = ends_of(Q, 0.003, 0.001);
    EXPECT_NEAR(wanted_slide_m(ends, Q), 0.002, 1e-9);
    ends[0]->information *= 3.0;
    EXPECT_NEAR(wanted_slide_m(ends, Q), 0.0025, 1e-9);
    ends[0].reset();
    EXPECT_NEAR(wanted_slide_m(ends, Q), 0.001, 1e-9);
    ends[1].reset();
    EXPECT_EQ(wanted_slide_m(ends, Q), 0.0);
}

TEST(WantedSlide, is_none_where_a_thread_is_too_long_at_both_ends) {
    const Eigen::Matrix3Xd Q = arc(2.0, 16);
    EXPECT_NEAR(wanted_slide_m(ends_of(Q, 0.002, -0.002), Q), 0.0, 1e-9);
}

TEST(NeededControlPoints, grow_with_length_and_with_bends) {
    EXPECT_EQ(needed_control_points(0.070), 16);
    EXPECT_EQ(needed_control_points(0.150), 32);
    const CubicBasis basis(16);
    EXPECT_EQ(needed_control_points(basis, arc(7.0, 16), 7.0 * kRadius_m), 24);
    EXPECT_EQ(needed_control_points(basis, arc(3.0, 16), 3.0 * kRadius_m), 16);
    EXPECT_EQ(needed_control_points(basis, arc(10.0, 16), 10.0 * kRadius_m), 32);
}

}  // namespace
}  // namespace atropos::tracker
