#include "tracker/light_rod.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "scenes/random_stream.hpp"
#include "tracker/nurbs_curve.hpp"
#include "tracker/rod_prediction.hpp"

namespace atropos::tracker {
namespace {

constexpr int kNodes = 51;

Eigen::Matrix3Xd arc(double radius_m, double angle) {
    Eigen::Matrix3Xd x(3, kNodes);
    for (int i = 0; i < kNodes; ++i) {
        const double a = angle * (static_cast<double>(i) / (kNodes - 1) - 0.5);
        x.col(i) = Eigen::Vector3d(radius_m * std::sin(a), radius_m * std::cos(a), 0.1);
    }
    return x;
}

Eigen::VectorXd edge_lengths(const Eigen::Matrix3Xd& x) {
    return (x.rightCols(x.cols() - 1) - x.leftCols(x.cols() - 1)).colwise().norm();
}

RC_GTEST_PROP(LightRod, keeps_every_edge_and_its_held_ends_wherever_it_is_carried, ()) {
    scenes::RandomStream random(*rc::gen::arbitrary<std::uint64_t>(), "carried");
    const LightRod rod(kNodes);
    const Eigen::Matrix3Xd before = arc(0.03, random.uniform(1.5, 3.0));
    Eigen::Matrix3Xd x = before;
    Eigen::Vector3d move[2];
    for (Eigen::Vector3d& m : move)
        m = 0.001 * Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    for (int i = 0; i < kNodes; ++i) {
        const double u = static_cast<double>(i) / (kNodes - 1);
        x.col(i) += (1.0 - u) * move[0] + u * move[1];
    }
    const Eigen::Matrix3Xd put = x;
    const LightRod::Held held = {random.uniform() < 0.7, random.uniform() < 0.7};
    RC_ASSERT(rod.keep_lengths(before, held, x));
    RC_ASSERT((edge_lengths(x) - edge_lengths(before)).cwiseAbs().maxCoeff() <
              1e-3 * edge_lengths(before).minCoeff());
    if (held[0]) RC_ASSERT(x.col(0) == put.col(0));
    if (held[1]) RC_ASSERT(x.col(kNodes - 1) == put.col(kNodes - 1));
}

TEST(LightRod, stays_where_nothing_moves_it_and_moves_whole_with_both_ends) {
    const LightRod rod(kNodes);
    const Eigen::Matrix3Xd before = arc(0.03, 2.0);
    Eigen::Matrix3Xd x = before;
    EXPECT_TRUE(rod.keep_lengths(before, {true, true}, x));
    EXPECT_EQ(x, before);
    x.colwise() += Eigen::Vector3d(0.01, -0.02, 0.03);
    const Eigen::Matrix3Xd moved = x;
    EXPECT_TRUE(rod.keep_lengths(before, {true, true}, x));
    EXPECT_TRUE(x.isApprox(moved, 1e-9));
}

TEST(LightRod, bulges_on_as_its_ends_approach) {
    const LightRod rod(kNodes);
    const Eigen::Matrix3Xd before = arc(0.03, 2.0);
    Eigen::Matrix3Xd x = before;
    x.row(0) *= 0.9;
    const double sag_before_m = before(1, kNodes / 2) - before(1, 0);
    ASSERT_TRUE(rod.keep_lengths(before, {true, true}, x));
    // An arc of the same length over the new chord.
    double angle = 2.0;
    for (int i = 0; i < 100; ++i)
        angle += 0.5 * (2.0 * std::sin(angle / 2.0) / angle / (0.9 * 2.0 * std::sin(1.0) / 2.0) - 1.0);
    const double radius_m = 0.06 / angle, sag_m = radius_m * (1.0 - std::cos(angle / 2.0));
    EXPECT_GT(x(1, kNodes / 2) - x(1, 0) - sag_before_m, 0.7 * (sag_m - sag_before_m));
    EXPECT_LT(x(1, kNodes / 2) - x(1, 0) - sag_before_m, 1.3 * (sag_m - sag_before_m));
}

TEST(LightRod, is_left_alone_where_its_ends_are_farther_apart_than_it_is_long) {
    const LightRod rod(kNodes);
    const Eigen::Matrix3Xd before = arc(0.03, 2.0);
    Eigen::Matrix3Xd x = 1.5 * before;
    const Eigen::Matrix3Xd stretched = x;
    EXPECT_FALSE(rod.keep_lengths(before, {true, true}, x));
    EXPECT_EQ(x, stretched);
}

/// Pulled down again and again until it hangs.
Eigen::Matrix3Xd hung(const Eigen::Matrix3Xd& from, LightRod::Held held) {
    const LightRod rod(kNodes);
    Eigen::Matrix3Xd x = from;
    for (const double by_m : {0.0005, 0.00002})
        for (int i = 0; i < 2000; ++i) {
            rod.pull({0.0, by_m, 0.0}, held, x);
            EXPECT_TRUE(rod.keep_lengths(from, held, x));
        }
    return x;
}

TEST(LightRod, hangs_as_a_catenary_between_two_ends) {
    const Eigen::Matrix3Xd from = arc(0.03, 2.2);
    const Eigen::Matrix3Xd x = hung(from, {true, true});
    const double length_m = edge_lengths(from).sum(), half_m = 0.5 * (from(0, kNodes - 1) - from(0, 0));
    double low = 1e-4, high = 10.0;  // of 2 a sinh(half / a) = length
    for (int i = 0; i < 200; ++i) {
        const double a = std::sqrt(low * high);
        (2.0 * a * std::sinh(half_m / a) > length_m ? low : high) = a;
    }
    for (int i = 0; i < kNodes; ++i) {
        const double below_m = low * (std::cosh(half_m / low) - std::cosh(x(0, i) / low));  // down is +y
        EXPECT_NEAR(x(1, i) - from(1, 0), below_m, 0.002 * length_m) << i;
        EXPECT_NEAR(x(2, i), 0.1, 1e-9);
    }
    EXPECT_LT(std::abs(edge_lengths(x).sum() - length_m), 1e-3 * length_m);
}

TEST(LightRod, hangs_straight_down_from_one_end) {
    const Eigen::Matrix3Xd from = arc(0.03, 2.2);
    const Eigen::Matrix3Xd x = hung(from, {true, false});
    EXPECT_NEAR(x(1, kNodes - 1) - x(1, 0), edge_lengths(from).sum(), 0.002 * edge_lengths(from).sum());
}

TEST(RodPrediction, leaves_a_curve_that_did_not_move_and_lengthens_none_that_did) {
    const CubicBasis basis(16);
    const RodPrediction rod(basis, Eigen::Vector3d::Zero());
    const Eigen::Matrix3Xd nodes = arc(0.03, 2.0);
    scenes::Polyline line;
    for (int i = 0; i < kNodes; ++i) line.points.emplace_back(nodes.col(i));
    const NurbsCurve curve = fit_curve(line, {.control_points = 16, .length_weight = 0.3});
    Eigen::Matrix3Xd Q(3, 16);
    for (int k = 0; k < 16; ++k) Q.col(k) = curve.control_points()[static_cast<std::size_t>(k)];
    Eigen::Matrix3Xd expected = Q;
    rod.correct(Q, {true, true}, 0.033, expected);
    EXPECT_TRUE(expected.isApprox(Q, 1e-12));
    expected.row(0) *= 0.95;
    const Eigen::Vector3d end = expected.col(15);
    rod.correct(Q, {true, true}, 0.033, expected);
    EXPECT_EQ(expected.col(15), end);
    const NurbsCurve moved(3, {expected.colwise().begin(), expected.colwise().end()});
    EXPECT_NEAR(moved.length(), curve.length(), 1e-3 * curve.length());
}

}  // namespace
}  // namespace atropos::tracker
