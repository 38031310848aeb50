#include "tracker/bordered_band_system.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "scenes/random_stream.hpp"

namespace atropos::tracker {
namespace {

constexpr int kControlPoints = 9, kBorder = 4, kUnknowns = 3 * kControlPoints + kBorder;

/// A system of random residuals and the same as a dense matrix and its right side.
struct Systems {
    BorderedBandSystem band{kControlPoints, kBorder};
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(kUnknowns, kUnknowns);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(kUnknowns);
};

Systems random_systems() {
    Systems s;
    scenes::RandomStream random(5, "residuals");
    for (int i = 0; i < 200; ++i) {
        const int first = i % (kControlPoints - 3);
        BorderedBandSystem::Block J;
        for (double& v : J) v = random.normal();
        BorderedBandSystem::Border border_J(kBorder);
        for (double& v : border_J) v = i % 3 == 0 ? 0.0 : random.normal();
        const double r = random.normal(), weight = random.uniform(0.5, 2.0);
        if (i % 3 == 0)
            s.band.add(first, J, r, weight);
        else
            s.band.add(first, J, border_J, r, weight);
        Eigen::VectorXd row = Eigen::VectorXd::Zero(kUnknowns);
        row.segment<12>(3 * first) = J;
        row.tail(kBorder) = border_J;
        s.dense += weight * row * row.transpose();
        s.right -= weight * r * row;
    }
    const BorderedBandSystem::BorderMatrix prior = 3.0 * BorderedBandSystem::BorderMatrix::Identity(4, 4);
    const BorderedBandSystem::Border error = BorderedBandSystem::Border::Constant(kBorder, 0.5);
    s.band.add_border(prior, error);
    s.dense.bottomRightCorner<kBorder, kBorder>() += prior;
    s.right.tail<kBorder>() -= prior * error;
    return s;
}

TEST(BorderedBandSystem, takes_the_step_of_the_dense_system) {
    Systems s = random_systems();
    const double damping = 0.3;
    Eigen::MatrixXd damped = s.dense;
    damped.diagonal() *= 1.0 + damping;
    const Eigen::VectorXd expected = damped.lu().solve(s.right);
    Eigen::VectorXd step;
    BorderedBandSystem::Border border_step;
    ASSERT_TRUE(s.band.solve(damping, step, border_step));
    EXPECT_TRUE(step.isApprox(expected.head(kUnknowns - kBorder), 1e-9));
    EXPECT_TRUE(border_step.isApprox(expected.tail(kBorder), 1e-9));
}

TEST(BorderedBandSystem, has_the_covariance_of_the_dense_system) {
    Systems s = random_systems();
    const Eigen::MatrixXd expected = s.dense.inverse();
    BorderedBandSystem::Covariance covariance;
    ASSERT_TRUE(s.band.covariance(covariance));
    constexpr int n = kUnknowns - kBorder;
    EXPECT_TRUE(covariance.curve.isApprox(expected.topLeftCorner<n, n>(), 1e-9));
    EXPECT_TRUE(covariance.across.isApprox(expected.topRightCorner<n, kBorder>(), 1e-9));
    EXPECT_TRUE(covariance.border.isApprox(expected.bottomRightCorner<kBorder, kBorder>(), 1e-9));
}

}  // namespace
}  // namespace atropos::tracker
