#include "tracker/curve_refinement.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tracker/nurbs_curve.hpp"

namespace atropos::tracker {
namespace {

constexpr int kControlPoints = 16, kSamples = 80;

/// A thread whose jaws turn it: 65 1/m at either end, over some millimetres, straight between.
scenes::Polyline clamped_thread() {
    scenes::Polyline line;
    Eigen::Vector3d p(-0.03, 0.0, 0.1);
    double turn = 0.4;
    for (int i = 0; i <= 400; ++i) {
        const double s = 0.070 * i / 400.0, step = 0.070 / 400.0;
        line.points.push_back(p);
        turn += step * 65.0 * (std::exp((s - 0.070) / 0.004) - std::exp(-s / 0.004));
        p += step * Eigen::Vector3d(std::cos(turn), std::sin(turn), 0.0);
    }
    return line;
}

Eigen::Matrix3Xd control_points_of(const scenes::Polyline& line) {
    const NurbsCurve curve = fit_curve(line, {.control_points = kControlPoints, .length_weight = 0.3});
    Eigen::Matrix3Xd Q(3, kControlPoints);
    for (int k = 0; k < kControlPoints; ++k) Q.col(k) = curve.control_points()[static_cast<std::size_t>(k)];
    return Q;
}

/// How far the ends come to lie from the truth when all but the jaws' last millimetres is seen perfectly.
double end_error_m(const CurvePriors& priors) {
    const scenes::StereoRig rig = scenes::parallel_rig(640, 360, 575.0, 0.005);
    CurveRefinement fit(kControlPoints, kSamples, priors, rig);
    const scenes::Polyline thread = clamped_thread();
    const Eigen::Matrix3Xd truth = control_points_of(thread);
    CurveProblem problem;
    problem.expected = truth;
    problem.length_m = thread.length_m();
    problem.length_sigma_m = 0.0002;
    for (std::size_t eye = 0; eye < 2; ++eye)
        for (std::size_t j = 0; j < kSamples; ++j) {
            LineMeasurement line;
            Eigen::Vector3d p = fit.samples()[j].point(truth), along = fit.samples()[j].tangent(truth);
            if (eye == 1) p = rig.X_RC * p;
            Eigen::Matrix<double, 2, 3> J_px;
            line.point_px = rig.left.project(p, J_px);
            const Eigen::Vector2d tangent = (J_px * along).normalized();
            line.normal = {-tangent.y(), tangent.x()};
            line.kind =
                j < 3 || j >= kSamples - 3 ? LineMeasurement::Kind::kHidden : LineMeasurement::Kind::kSeen;
            problem.lines[eye].push_back(line);
        }
    Eigen::Matrix3Xd Q = truth;
    double length_m = problem.length_m;
    fit.refine(problem, 20, Q, length_m);
    return 0.5 * ((Q.col(0) - truth.col(0)).norm() + (Q.rightCols<1>() - truth.rightCols<1>()).norm());
}

TEST(CurveRefinement, lets_jaws_turn_the_thread) {
    CurvePriors even;
    even.clamp_factor = 1.0;
    EXPECT_LT(end_error_m({}), 0.7 * end_error_m(even));
}

}  // namespace
}  // namespace atropos::tracker
