#include "tracker/deformation_prior.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/random_stream.hpp"
#include "tests/support/synthetic_sequence.hpp"
#include "tests/support/tracking_trial.hpp"
#include "tracker/curve_refinement.hpp"
#include "tracker/deformation_learner.hpp"
#include "tracker/refined_tracker.hpp"

namespace atropos::tracker {
namespace {

constexpr int kK = 16;

/// Sags by 15 mm over a chord of 60 mm, at 100 mm from the camera.
Eigen::Matrix3Xd sagging_curve(int K = kK) {
    Eigen::Matrix3Xd Q(3, K);
    for (int k = 0; k < K; ++k) {
        const double u = static_cast<double>(k) / (K - 1);
        Q.col(k) = Eigen::Vector3d(-0.03 + 0.06 * u, 0.060 * u * (1.0 - u), 0.1);
    }
    return Q;
}

Eigen::Matrix3d random_rotation(scenes::RandomStream& random) {
    return Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
        .normalized()
        .toRotationMatrix();
}

/// Orthonormal modes of definite parity: sine half waves along one of the thread's axes.
Eigen::MatrixXd sine_modes() {
    constexpr std::array<std::pair<int, int>, 4> kAxisAndWave = {{{1, 1}, {2, 1}, {1, 2}, {2, 2}}};
    Eigen::MatrixXd modes = Eigen::MatrixXd::Zero(3 * kK, 4);
    for (int m = 0; m < 4; ++m)
        for (int k = 0; k < kK; ++k)
            modes(3 * k + kAxisAndWave[static_cast<std::size_t>(m)].first, m) =
                std::sin(std::numbers::pi * kAxisAndWave[static_cast<std::size_t>(m)].second * k / (kK - 1)) *
                std::sqrt(2.0 / (kK - 1));
    return modes;
}

DeformationPrior sine_prior() {
    return {.control_points = kK,
            .modes = sine_modes(),
            .sigmas_m = Eigen::Vector4d(8e-4, 5e-4, 3e-4, 2e-4),
            .rest_sigma_m = 5e-5};
}

RC_GTEST_PROP(DeformationLearner, finds_what_a_singular_value_decomposition_finds_in_a_low_rank_set, ()) {
    scenes::RandomStream random(*rc::gen::arbitrary<std::uint64_t>(), "deformations");
    const Eigen::MatrixXd modes = sine_modes();
    const Eigen::Vector4d sigmas(8e-4, 4e-4, 2e-4, 1e-4);
    DeformationLearner learner(kK);
    learner.begin_track();
    // Each curve is where it was, what half of its velocity does, and a deformation.
    const double dt = 1.0 / 30;
    Eigen::Matrix3Xd Q = sagging_curve(), velocity = Eigen::Matrix3Xd::Zero(3, kK);
    learner.add(Q, 0.0);
    const int count = 300;
    Eigen::MatrixXd deformations(3 * kK, count);
    for (int t = 1; t <= count + 2; ++t) {
        const Eigen::Vector4d a =
            sigmas.array() * Eigen::Vector4d::NullaryExpr([&] { return random.normal(); }).array();
        const Eigen::VectorXd d = modes * a;
        if (t > 2) deformations.col(t - 3) = d;
        const Eigen::Matrix3Xd by = thread_frame(Q) * d.reshaped(3, kK);
        Q += 0.5 * dt * velocity + by;
        velocity = 0.5 * velocity + by / dt;
        learner.add(Q, t * dt);
    }
    // Mirrored across the plane of the sag, and seen from the other end.
    Eigen::MatrixXd alike(3 * kK, 4 * count);
    for (int k = 0; k < kK; ++k)
        for (int axis = 0; axis < 3; ++axis) {
            const auto own = deformations.row(3 * k + axis),
                       other = deformations.row(3 * (kK - 1 - k) + axis);
            const double mirrored = axis == 2 ? -1.0 : 1.0, reversed = axis == 0 ? -1.0 : 1.0;
            alike.row(3 * k + axis) << own, mirrored * own, reversed * other, mirrored * reversed * other;
        }
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(alike, Eigen::ComputeThinU);
    const DeformationPrior prior = learner.learn(3);
    for (int m = 0; m < 3; ++m) {
        const double sigma = svd.singularValues()[m] / std::sqrt(4.0 * count);
        RC_ASSERT(std::abs(prior.sigmas_m[m] - sigma) < 1e-9 * sigma);
        RC_ASSERT(std::abs(std::abs(svd.matrixU().col(m).dot(prior.modes.col(m))) - 1.0) < 1e-9);
    }
    const double all = svd.singularValues().squaredNorm() / (4.0 * count);
    const double kept = prior.sigmas_m.squaredNorm() + (3 * (kK - 2) - 3) * std::pow(prior.rest_sigma_m, 2);
    RC_ASSERT(std::abs(kept - all) < 1e-6 * all);
}

TEST(DeformationLearner, refuses_what_it_cannot_learn_from) {
    DeformationLearner learner(kK);
    learner.begin_track();
    learner.add(sagging_curve(), 0.0);
    EXPECT_THROW(learner.add(sagging_curve(8), 0.1), std::invalid_argument);
    EXPECT_THROW(learner.add(sagging_curve(), 0.0), std::invalid_argument);
    EXPECT_THROW(learner.learn(3), std::invalid_argument);
    for (int t = 1; t < 100; ++t) learner.add(sagging_curve(), t);
    EXPECT_THROW(learner.learn(3), std::invalid_argument);  // nothing moves
}

RC_GTEST_PROP(ThreadFrame, turns_with_the_thread, ()) {
    scenes::RandomStream random(*rc::gen::arbitrary<std::uint64_t>(), "turns");
    const Eigen::Matrix3d R = random_rotation(random), axes = thread_frame(sagging_curve());
    RC_ASSERT(axes.isApprox(Eigen::Matrix3d::Identity(), 1e-12));
    RC_ASSERT(thread_frame(R * sagging_curve()).isApprox(R, 1e-9));
}

TEST(ThreadFrame, is_one_for_straight_and_for_closed_threads_too) {
    Eigen::Matrix3Xd straight = sagging_curve(), closed = sagging_curve();
    straight.row(1).setZero();
    closed.col(kK - 1) = closed.col(0);
    for (const Eigen::Matrix3Xd& Q : {straight, closed}) {
        const Eigen::Matrix3d axes = thread_frame(Q);
        EXPECT_TRUE((axes.transpose() * axes).isIdentity(1e-12));
        EXPECT_NEAR(axes.determinant(), 1.0, 1e-12);
    }
    EXPECT_NEAR(thread_frame(straight).col(1).z(), 1.0, 1e-12);  // away from the camera
}

RC_GTEST_PROP(DeformationModes, cost_what_the_dense_covariance_says_and_pull_along_its_gradient, ()) {
    scenes::RandomStream random(*rc::gen::arbitrary<std::uint64_t>(), "offsets");
    DeformationModes modes = placed(sine_prior(), random_rotation(random) * sagging_curve(), 1.0 / 30);
    modes.weight = 1.0;
    const Eigen::VectorXd offset =
        3e-4 * Eigen::VectorXd::NullaryExpr(3 * kK, [&] { return random.normal(); });
    const Eigen::MatrixXd covariance =
        modes.V * modes.sigmas_m.cwiseAbs2().asDiagonal() * modes.V.transpose() +
        std::pow(modes.rest_sigma_m, 2) * Eigen::MatrixXd::Identity(3 * kK, 3 * kK);
    const double squared = offset.dot(covariance.inverse() * offset);
    Eigen::VectorXd unexplained;
    double information = 0.0;
    const double cost = modes.cost(offset, unexplained, information);
    RC_ASSERT(std::abs(cost - 0.5 * (4.0 + 3 * kK) * std::log1p(squared / 4.0)) < 1e-8 * cost);
    Eigen::VectorXd ignored;
    double other = 0.0;
    for (const int i : {4, 20, 33}) {
        const double h = 1e-8;
        Eigen::VectorXd ahead = offset, behind = offset;
        ahead[i] += h;
        behind[i] -= h;
        const double slope =
            (modes.cost(ahead, ignored, other) - modes.cost(behind, ignored, other)) / (2 * h);
        RC_ASSERT(std::abs(information * unexplained[i] - slope) < 1e-4 * (std::abs(slope) + 1.0));
    }
}

TEST(DeformationModes, spread_with_the_time_between_frames) {
    const DeformationModes once = placed(sine_prior(), sagging_curve(), 1.0 / 30),
                           later = placed(sine_prior(), sagging_curve(), 5.0 / 30);
    EXPECT_TRUE(later.sigmas_m.isApprox(5.0 * once.sigmas_m, 1e-12));
    EXPECT_NEAR(later.rest_sigma_m, 5.0 * once.rest_sigma_m, 1e-12);
}

/// A half of the thread is seen 2 mm further down the picture than it was expected.
CurveProblem half_seen(const CurveRefinement& fit, const scenes::StereoRig& rig, const Eigen::Matrix3Xd& Q) {
    CurveProblem problem;
    problem.expected = Q;
    problem.length_m = sampled(NurbsCurve(3, {Q.colwise().begin(), Q.colwise().end()}), 200).length_m();
    problem.length_sigma_m = 0.003;
    for (std::size_t eye = 0; eye < 2; ++eye)
        for (std::size_t j = 0; j < fit.samples().size(); ++j) {
            LineMeasurement line;
            Eigen::Vector3d p = fit.samples()[j].point(Q) + Eigen::Vector3d(0.0, 0.002, 0.0);
            if (eye == 1) p = rig.X_RC * p;
            Eigen::Matrix<double, 2, 3> J_px;
            line.point_px = (eye == 0 ? rig.left : rig.right).project(p, J_px);
            const Eigen::Vector3d tangent = fit.samples()[j].tangent(Q);
            const Eigen::Vector2d along = (J_px * tangent).normalized();
            line.normal = {-along.y(), along.x()};
            line.kind =
                2 * j < fit.samples().size() ? LineMeasurement::Kind::kSeen : LineMeasurement::Kind::kHidden;
            problem.lines[eye].push_back(line);
        }
    return problem;
}

TEST(CurveRefinement, moves_a_hidden_half_with_the_seen_one_as_was_learned) {
    const scenes::StereoRig rig = scenes::parallel_rig(640, 360, 575.0, 0.005);
    CurvePriors soft;
    soft.curvature_sigma_per_m = soft.curvature_change_sigma_per_m2 = 1e5;
    soft.stretch_sigma = 1.0;
    CurveRefinement fit(kK, 80, soft, rig);
    const Eigen::Matrix3Xd Q = sagging_curve();
    CurveProblem problem = half_seen(fit, rig, Q);
    const auto hidden_moved_m = [&] {
        Eigen::Matrix3Xd found = Q;
        double length_m = problem.length_m;
        fit.refine(problem, 30, found, length_m);
        return found(1, 12) - Q(1, 12);
    };
    const double without_m = hidden_moved_m();
    DeformationPrior prior = sine_prior();
    prior.sigmas_m = Eigen::Vector4d(2e-3, 5e-5, 5e-5, 5e-5);
    problem.deformation = placed(prior, Q, 1.0 / 30);
    const double learned_m = 0.002 * std::sin(std::numbers::pi * 12 / (kK - 1));
    EXPECT_GT(std::abs(without_m - learned_m), 0.0008);
    EXPECT_NEAR(hidden_moved_m(), learned_m, 0.0003);
}

TEST(CurveRefinement, is_the_same_to_the_byte_with_a_prior_of_no_weight) {
    const scenes::StereoRig rig = scenes::parallel_rig(640, 360, 575.0, 0.005);
    CurveRefinement fit(kK, 80, {}, rig);
    const Eigen::Matrix3Xd Q = sagging_curve();
    CurveProblem problem = half_seen(fit, rig, Q);
    Eigen::Matrix3Xd without = Q, with = Q;
    double length_m = problem.length_m, other_m = length_m;
    fit.refine(problem, 10, without, length_m);
    problem.deformation = placed(sine_prior(), Q, 1.0 / 30);
    problem.deformation.weight = 0.0;
    fit.refine(problem, 10, with, other_m);
    EXPECT_EQ(without, with);
    EXPECT_EQ(length_m, other_m);
    problem.deformation.weight = 1.0;
    fit.refine(problem, 10, with, other_m);
    EXPECT_NE(without, with);
}

TEST(RefinedTracker, is_the_same_to_the_byte_with_a_prior_of_no_weight) {
    const support::SyntheticSequenceOptions options{.seed = 5,
                                                    .rig = scenes::parallel_rig(320, 180, 287.5, 0.005)};
    const support::SyntheticSequence sequence(options);
    scenes::TrackerConfig config;
    config.method = scenes::TrackerMethod::kRefined;
    config.thread.length_m = options.length_m;
    const auto curves = [&](const DeformationPrior* prior, double weight) {
        config.refined.prior_weight = weight;
        const auto tracker = make_tracker(config, options.rig, prior);
        std::vector<Eigen::Vector3d> all;
        for (int i = 0; i < 4; ++i) {
            const support::SyntheticFrame drawn = sequence.frame(5 * i);
            const StereoFrame frame = support::stereo_frame(drawn, i);
            const TrackResult& result =
                i == 0 ? tracker->start(frame, fit_curve(drawn.truth_C, {.control_points = 12}))
                       : tracker->track(frame);
            all.insert(all.end(), result.control_points.begin(), result.control_points.end());
        }
        return all;
    };
    const DeformationPrior prior = sine_prior();
    const auto without = curves(nullptr, 1.0);
    EXPECT_EQ(without, curves(&prior, 0.0));
    EXPECT_NE(without, curves(&prior, 1.0));
}

TEST(MakeTracker, wants_the_prior_that_is_named_and_one_of_its_own_K) {
    const scenes::StereoRig rig = scenes::parallel_rig(320, 180, 287.5, 0.005);
    scenes::TrackerConfig config;
    config.method = scenes::TrackerMethod::kRefined;
    config.refined.prior_file = "prior.json";
    DeformationPrior prior = sine_prior();
    EXPECT_THROW(make_tracker(config, rig), std::invalid_argument);
    EXPECT_NO_THROW(make_tracker(config, rig, &prior));
    config.refined.control_points = 12;
    EXPECT_THROW(make_tracker(config, rig, &prior), std::invalid_argument);
    config.refined.control_points = kK;
    prior.modes *= 2.0;
    EXPECT_THROW(make_tracker(config, rig, &prior), std::invalid_argument);
}

}  // namespace
}  // namespace atropos::tracker
