#include "tracker/nurbs_curve.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "scenes/random_stream.hpp"

namespace atropos::tracker {
namespace {

/// A curve of 20 mm control polygon steps about 100 mm before the camera, with weights in [0.5, 2].
NurbsCurve random_curve(std::uint64_t seed) {
    scenes::RandomStream random(seed, "curve");
    const int degree = 1 + static_cast<int>(random.integer(5));
    const int count = degree + 1 + static_cast<int>(random.integer(10));
    std::vector<Eigen::Vector3d> points;
    std::vector<double> weights;
    std::vector<double> knots(static_cast<std::size_t>(degree + 1), 0.0);
    for (int i = 0; i < count - degree - 1; ++i) knots.push_back(random.uniform(0.01, 0.99));
    std::sort(knots.begin(), knots.end());
    knots.insert(knots.end(), static_cast<std::size_t>(degree + 1), 1.0);
    for (int k = 0; k < count; ++k) {
        points.emplace_back(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02),
                            random.uniform(0.08, 0.12));
        weights.push_back(random.uniform(0.5, 2.0));
    }
    return {BsplineBasis(degree, std::move(knots)), std::move(points), std::move(weights)};
}

Eigen::Matrix<double, 3, 4> random_camera(std::uint64_t seed) {
    scenes::RandomStream random(seed, "camera");
    Eigen::Matrix3d K;
    const double f_px = random.uniform(300.0, 2000.0);
    K << f_px, random.uniform(-1.0, 1.0), 320.0, 0.0, f_px * random.uniform(0.9, 1.1), 180.0, 0.0, 0.0, 1.0;
    const Eigen::AngleAxisd turn(
        random.uniform(-0.3, 0.3),
        Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized());
    Eigen::Matrix<double, 3, 4> X;
    X << turn.toRotationMatrix(),
        Eigen::Vector3d(random.uniform(-0.01, 0.01), random.uniform(-0.01, 0.01), 0.0);
    return K * X;
}

RC_GTEST_PROP(NurbsCurve, sums_its_basis_to_one, (std::uint64_t seed)) {
    const NurbsCurve curve = random_curve(seed);
    for (int j = 0; j <= 50; ++j) {
        const Eigen::VectorXd R = curve.rational_basis(j / 50.0);
        RC_ASSERT(std::abs(R.sum() - 1.0) < 1e-12);
        RC_ASSERT(R.minCoeff() >= 0.0);
    }
}

RC_GTEST_PROP(NurbsCurve, begins_and_ends_at_its_outer_control_points, (std::uint64_t seed)) {
    const NurbsCurve curve = random_curve(seed);
    RC_ASSERT((curve.point(0.0) - curve.control_points().front()).norm() < 1e-15);
    RC_ASSERT((curve.point(1.0) - curve.control_points().back()).norm() < 1e-15);
}

RC_GTEST_PROP(NurbsCurve, moves_with_its_control_points_under_affine_maps, (std::uint64_t seed)) {
    NurbsCurve curve = random_curve(seed);
    const Eigen::Matrix3d A = random_camera(seed).leftCols<3>() / 500.0;
    const Eigen::Vector3d t(0.1, -0.2, 0.3);
    const NurbsCurve before = curve;
    std::vector<Eigen::Vector3d> moved;
    for (const Eigen::Vector3d& q : curve.control_points()) moved.emplace_back(A * q + t);
    curve.set_control_points(moved);
    for (int j = 0; j <= 20; ++j)
        RC_ASSERT((curve.point(j / 20.0) - (A * before.point(j / 20.0) + t)).norm() < 1e-13);
}

RC_GTEST_PROP(NurbsCurve, projects_by_its_control_points_and_weights, (std::uint64_t seed)) {  // eq. 3
    const NurbsCurve curve = random_curve(seed);
    const Eigen::Matrix<double, 3, 4> P = random_camera(seed);
    const ImageCurve image = project(P, curve);
    for (int j = 0; j <= 50; ++j) {
        const Eigen::Vector2d direct = (P * curve.point(j / 50.0).homogeneous()).hnormalized();
        RC_ASSERT((image.point(j / 50.0) - direct).norm() < 1e-10);
    }
}

RC_GTEST_PROP(NurbsCurve, has_the_derivatives_of_its_differences, (std::uint64_t seed)) {
    const NurbsCurve curve = random_curve(seed);
    const std::vector<double> knots = curve.basis().distinct_knots();
    for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
        const double width = knots[i + 1] - knots[i];
        const double u = knots[i] + 0.4 * width;
        const double h = 1e-4 * width;
        for (int order = 1; order <= 3; ++order) {
            const Eigen::Vector3d difference =
                (curve.derivative(u + h, order - 1) - curve.derivative(u - h, order - 1)) / (2.0 * h);
            const double scale = curve.derivative(u, order + 2).norm() * width * width +
                                 curve.derivative(u, order - 1).norm() / width;
            RC_ASSERT((curve.derivative(u, order) - difference).norm() < 1e-6 * scale);
        }
    }
}

RC_GTEST_PROP(NurbsCurve, keeps_its_shape_when_a_knot_is_inserted, (std::uint64_t seed)) {
    const NurbsCurve curve = random_curve(seed);
    const NurbsCurve finer = curve.with_knot(0.01 + 0.98 * static_cast<double>(seed % 1000) / 1000.0);
    RC_ASSERT(finer.control_points().size() == curve.control_points().size() + 1);
    for (int j = 0; j <= 30; ++j) RC_ASSERT((finer.point(j / 30.0) - curve.point(j / 30.0)).norm() < 1e-13);
}

TEST(NurbsCurve, draws_an_exact_quarter_circle_with_weights) {
    const double r = 0.03;
    const NurbsCurve circle(BsplineBasis(2, 3), {{r, 0, 0}, {r, r, 0}, {0, r, 0}},
                            {1.0, std::sqrt(0.5), 1.0});
    for (int j = 0; j <= 20; ++j) EXPECT_NEAR(circle.point(j / 20.0).norm(), r, 1e-16);
    EXPECT_NEAR(circle.length(), 0.5 * std::numbers::pi * r, 1e-12);
    EXPECT_NEAR(circle.length(0.0, 0.5), 0.25 * std::numbers::pi * r, 1e-12);
}

TEST(NurbsCurve, refuses_what_is_not_a_curve) {
    EXPECT_THROW(NurbsCurve(3, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}), std::invalid_argument);
    EXPECT_THROW(BsplineBasis(2, std::vector<double>{0, 0, 0.1, 1, 1, 1}), std::invalid_argument);
    EXPECT_THROW(NurbsCurve(BsplineBasis(1, 2), {{0, 0, 0}, {1, 0, 0}}, {1.0, 0.0}), std::invalid_argument);
}

scenes::Polyline half_circle(double length) {
    scenes::Polyline arc;
    const double r = length / std::numbers::pi;
    for (int j = 0; j <= 200; ++j) {
        const double a = std::numbers::pi * j / 200.0;
        arc.points.emplace_back(r * std::cos(a), r * std::sin(a), 0.1);
    }
    return arc;
}

TEST(FitCurve, follows_the_points_it_is_given) {
    const NurbsCurve curve = fit_curve(half_circle(0.07), {.control_points = 10});
    for (int j = 0; j <= 100; ++j)
        EXPECT_NEAR(curve.point(j / 100.0).head<2>().norm(), 0.07 / std::numbers::pi, 1e-5);
}

TEST(FitCurve, keeps_an_even_speed_with_the_length_term) {
    const auto stretch = [](const NurbsCurve& curve) {
        double sum = 0.0;
        for (int j = 0; j <= 100; ++j) sum += std::pow(curve.derivative(j / 100.0).norm() / 0.07 - 1.0, 2);
        return std::sqrt(sum / 101.0);
    };
    const NurbsCurve plain = fit_curve(half_circle(0.07), {.control_points = 6});
    const NurbsCurve even = fit_curve(half_circle(0.07), {.control_points = 6, .length_weight = 1.0});
    EXPECT_LT(stretch(even), 0.9 * stretch(plain));
}

}  // namespace
}  // namespace atropos::tracker
