#include "tracker/end_belief.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "scenes/random_stream.hpp"

namespace atropos::tracker {
namespace {

const Eigen::Matrix3d kI = Eigen::Matrix3d::Identity();
const Eigen::Vector3d kMeasured_C(0.01, 0.0, 0.1);

/// A fit that knows the end to `information` by itself, at `seen_C`, and was told what `belief` expects.
EndEvidence fit_of(const EndBelief& belief, const Eigen::Vector3d& seen_C, const Eigen::Matrix3d& information,
                   double noise_share) {
    const UncertainPoint expected = belief.expected(kMeasured_C);
    const Eigen::Matrix3d told = expected.covariance.inverse();
    const Eigen::Matrix3d covariance = (told + information).inverse();
    const Eigen::Vector3d fitted = covariance * (told * expected.p_C + information * seen_C);
    return end_evidence(expected.p_C, told, {fitted, covariance},
                        noise_share * covariance * information * covariance);
}

Eigen::Matrix3d information_of(double sigma_m) {
    return 1.0 / (sigma_m * sigma_m) * kI;
}

TEST(EndEvidence, is_what_the_fit_knew_apart_from_what_it_was_told) {
    const EndBelief belief({});
    const Eigen::Vector3d seen_C = kMeasured_C + Eigen::Vector3d(0.001, -0.0005, 0.002);
    const Eigen::Matrix3d information = Eigen::Vector3d(4e6, 1e6, 1e5).asDiagonal();
    const EndEvidence evidence = fit_of(belief, seen_C, information, 0.25);
    EXPECT_TRUE(evidence.information.isApprox(information, 1e-6));
    EXPECT_TRUE(evidence.new_part.isApprox(0.25 * information, 1e-6));
    EXPECT_TRUE(evidence.score.isApprox(information * (seen_C - kMeasured_C), 1e-6));
}

TEST(FittedEnds, are_those_of_a_fit_that_was_told_otherwise) {
    // The curve's length ties the ends to each other.
    Matrix6d images = 1e5 * Matrix6d::Identity();
    images.block<3, 3>(0, 3) = images.block<3, 3>(3, 0) = 6e4 * kI;
    const Vector6d seen = Vector6d::LinSpaced(0.001, 0.006);
    const auto fit_told = [&](const ToldEnd& first, const ToldEnd& second) {
        Matrix6d information = images;
        information.topLeftCorner<3, 3>() += first.information;
        information.bottomRightCorner<3, 3>() += second.information;
        FittedEnds fit;
        fit.covariance = information.inverse();
        Vector6d told;
        told.head<3>() = first.information.diagonal().cwiseProduct(first.p_C);
        told.tail<3>() = second.information.diagonal().cwiseProduct(second.p_C);
        fit.p_C = fit.covariance * (images * seen + told);
        fit.by_noise = fit.covariance * (0.5 * images) * fit.covariance;
        return fit;
    };
    const ToldEnd first{Eigen::Vector3d(0.001, 0.0, 0.002), 3e5 * kI};
    const ToldEnd sure{Eigen::Vector3d(0.005, 0.004, 0.006), 2e6 * kI};
    const ToldEnd unsure{Eigen::Vector3d(0.004, 0.0045, 0.005), 4e5 * kI};
    const FittedEnds got = told_instead(fit_told(first, sure), 1, sure, unsure);
    const FittedEnds wanted = fit_told(first, unsure);
    EXPECT_TRUE(got.p_C.isApprox(wanted.p_C, 1e-9));
    EXPECT_TRUE(got.covariance.isApprox(wanted.covariance, 1e-9));
    EXPECT_TRUE(got.by_noise.isApprox(wanted.by_noise, 1e-9));
}

TEST(EndBelief, finds_a_constant_error_that_images_show_under_noise) {
    EndBelief belief({});
    scenes::RandomStream random(1, "noise");
    const Eigen::Vector3d error(0.001, -0.0008, 0.0012);
    for (int i = 0; i < 100; ++i) {
        belief.wait(1.0 / 30.0);
        const Eigen::Vector3d noise(random.normal(0.0, 5e-4), random.normal(0.0, 5e-4),
                                    random.normal(0.0, 5e-4));
        belief.learn(fit_of(belief, kMeasured_C + error + noise, information_of(5e-4), 1.0));
    }
    EXPECT_LT((belief.bias_C() - error).norm(), 0.0003);
}

TEST(EndBelief, counts_a_pull_that_every_frame_repeats_as_one_look) {
    EndBelief once({}), often({});
    const Eigen::Vector3d pulled_C = kMeasured_C + Eigen::Vector3d(0.001, 0.0, 0.0);
    once.learn(fit_of(once, pulled_C, information_of(0.002), 0.0));
    for (int i = 0; i < 300; ++i) often.learn(fit_of(often, pulled_C, information_of(0.002), 0.0));
    EXPECT_GT(once.bias_C().x(), 0.0001);
    EXPECT_LT(often.bias_C().x(), 1.2 * once.bias_C().x());
    EXPECT_GT(often.expected(kMeasured_C).covariance(0, 0),
              0.9 * once.expected(kMeasured_C).covariance(0, 0));
}

TEST(EndBelief, learns_nothing_in_a_direction_that_nothing_looks_along) {
    EndBelief belief({});
    const double before = belief.expected(kMeasured_C).covariance(2, 2);
    const Eigen::Matrix3d information = Eigen::Vector3d(4e6, 4e6, 0.0).asDiagonal();
    for (int i = 0; i < 100; ++i)
        belief.learn(fit_of(belief, kMeasured_C + Eigen::Vector3d(0.0005, 0.0, 0.05), information, 0.5));
    EXPECT_NEAR(belief.bias_C().z(), 0.0, 1e-5);
    EXPECT_NEAR(belief.expected(kMeasured_C).covariance(2, 2), before, 0.01 * before);
    EXPECT_GT(belief.bias_C().x(), 0.0002);
}

TEST(EndBelief, does_not_follow_an_end_that_leaps) {
    EndBelief belief({});
    for (int i = 0; i < 20; ++i) belief.learn(fit_of(belief, kMeasured_C, information_of(5e-4), 1.0));
    const Eigen::Vector3d before = belief.bias_C();
    belief.learn(fit_of(belief, kMeasured_C + Eigen::Vector3d(0.0, 0.0, 0.006), information_of(2e-4), 1.0));
    EXPECT_EQ(belief.bias_C(), before);
}

TEST(EndBelief, returns_to_what_was_promised_of_the_arm_when_nothing_is_seen) {
    EndBelief belief({});
    for (int i = 0; i < 50; ++i)
        belief.learn(
            fit_of(belief, kMeasured_C + Eigen::Vector3d(0.001, 0.0, 0.0), information_of(3e-4), 1.0));
    EXPECT_GT(belief.bias_C().x(), 0.0005);
    belief.wait(200.0);
    EXPECT_LT(belief.bias_C().x(), 1e-6);
    EXPECT_TRUE(belief.expected(kMeasured_C)
                    .covariance.isApprox(EndBelief({}).expected(kMeasured_C).covariance, 1e-3));
}

TEST(EndBelief, goes_on_from_what_was_saved) {
    EndBelief belief({}), again({});
    belief.learn(fit_of(belief, kMeasured_C + Eigen::Vector3d(0.001, 0.0, 0.0), information_of(3e-4), 0.5));
    belief.learn_excess(0.0003, 0.0002);
    double state[EndBelief::kStateSize];
    belief.save(state);
    again.load(state);
    EXPECT_EQ(again.bias_C(), belief.bias_C());
    EXPECT_EQ(again.excess_variance_m2(), belief.excess_variance_m2());
    EXPECT_EQ(again.expected(kMeasured_C).covariance, belief.expected(kMeasured_C).covariance);
}

}  // namespace
}  // namespace atropos::tracker
