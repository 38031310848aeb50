#include "tracker/slow_belief.hpp"

#include <gtest/gtest.h>

#include "scenes/random_stream.hpp"

namespace atropos::tracker {
namespace {

using Belief = SlowBelief<3>;
const Eigen::Matrix3d kI = Eigen::Matrix3d::Identity();

/// An arm's error in mm: of one, for 20 s; with `unsure`, now and then of five.
Belief belief_of(bool unsure = false) {
    Belief::Options options;
    options.hypotheses = {{Eigen::Vector3d::Constant(1.0), 0.95}};
    if (unsure) options.hypotheses.push_back({Eigen::Vector3d::Constant(5.0), 0.05});
    options.forget_s = Eigen::Vector3d::Constant(20.0);
    options.floor = Eigen::Vector3d::Constant(0.1);
    options.useless = Eigen::Vector3d::Constant(20.0);
    return Belief(options);
}

/// A fit that sees them at `seen` to `information` by itself, and was told what `belief` expects.
Evidence<3> fit_of(const Belief& belief, const Eigen::Vector3d& seen, const Eigen::Matrix3d& information,
                   double noise_share) {
    const Eigen::Matrix3d covariance = (belief.information() + information).inverse();
    const Eigen::Vector3d fitted = covariance * (belief.information() * belief.mean() + information * seen);
    return evidence_of<3>(belief.mean(), belief.information(), fitted, covariance,
                          noise_share * covariance * information * covariance);
}

void learn(Belief& belief, const Eigen::Vector3d& seen, const Eigen::Matrix3d& information,
           double noise_share) {
    belief.learn(fit_of(belief, seen, information, noise_share),
                 [](const Eigen::Vector3d& surprise, const Eigen::Matrix3d& S) {
                     return surprise.dot(S.inverse() * surprise) > 11.3;
                 });
}

TEST(Evidence, is_what_the_fit_knew_apart_from_what_it_was_told) {
    const Belief belief = belief_of();
    const Eigen::Vector3d seen(1.0, -0.5, 2.0);
    const Eigen::Matrix3d information = Eigen::Vector3d(4.0, 1.0, 0.1).asDiagonal();
    const Evidence<3> evidence = fit_of(belief, seen, information, 0.25);
    EXPECT_TRUE(evidence.information.isApprox(information, 1e-6));
    EXPECT_TRUE(evidence.new_part.isApprox(0.25 * information, 1e-6));
    EXPECT_TRUE(evidence.score.isApprox(information * seen, 1e-6));
}

TEST(SlowBelief, finds_a_constant_error_that_images_show_under_noise) {
    Belief belief = belief_of();
    scenes::RandomStream random(1, "noise");
    const Eigen::Vector3d error(1.0, -0.8, 1.2);
    for (int i = 0; i < 100; ++i) {
        belief.wait(1.0 / 30.0);
        const Eigen::Vector3d noise(random.normal(0.0, 0.5), random.normal(0.0, 0.5),
                                    random.normal(0.0, 0.5));
        learn(belief, error + noise, 4.0 * kI, 1.0);
    }
    EXPECT_LT((belief.mean() - error).norm(), 0.3);
    EXPECT_LT(belief.covariance()(0, 0), 0.15 * 0.15);
}

TEST(SlowBelief, counts_a_pull_that_every_frame_repeats_as_one_look) {
    Belief once = belief_of(), often = belief_of();
    const Eigen::Vector3d pulled(1.0, 0.0, 0.0);
    learn(once, pulled, 0.25 * kI, 0.0);
    for (int i = 0; i < 300; ++i) learn(often, pulled, 0.25 * kI, 0.0);
    EXPECT_GT(once.mean().x(), 0.1);
    EXPECT_LT(often.mean().x(), 1.05 * once.mean().x());
    EXPECT_GT(often.covariance()(0, 0), 0.95 * once.covariance()(0, 0));
}

TEST(SlowBelief, learns_nothing_in_a_direction_that_nothing_looks_along) {
    Belief belief = belief_of();
    const double before = belief.covariance()(2, 2);
    const Eigen::Matrix3d information = Eigen::Vector3d(4.0, 4.0, 0.0).asDiagonal();
    for (int i = 0; i < 100; ++i) learn(belief, {0.5, 0.0, 50.0}, information, 0.5);
    EXPECT_NEAR(belief.mean().z(), 0.0, 0.01);
    EXPECT_NEAR(belief.covariance()(2, 2), before, 0.01 * before);
    EXPECT_GT(belief.mean().x(), 0.2);
}

TEST(SlowBelief, puts_together_what_each_frame_shows_of_it) {
    // x + y from some frames, x - y from others: neither shows x.
    Belief belief = belief_of();
    for (int i = 0; i < 50; ++i) {
        const Eigen::Vector3d along = Eigen::Vector3d(1.0, i % 2 == 0 ? 1.0 : -1.0, 0.0).normalized();
        learn(belief, {1.0, -0.5, 0.0}, 100.0 * along * along.transpose(), 1.0);
    }
    EXPECT_NEAR(belief.mean().x(), 1.0, 0.1);
    EXPECT_NEAR(belief.mean().y(), -0.5, 0.1);
}

TEST(SlowBelief, believes_an_unlikely_error_when_everything_speaks_for_it_and_not_before) {
    Belief belief = belief_of(true);
    learn(belief, {1.0, 0.0, 0.0}, 0.25 * kI, 1.0);
    EXPECT_LT(belief.mean().x(), 0.4);
    Belief far = belief_of(true);
    for (int i = 0; i < 5; ++i) learn(far, {6.0, 0.0, 0.0}, 4.0 * kI, 1.0);
    EXPECT_NEAR(far.mean().x(), 6.0, 0.4);
    Belief sure = belief_of();
    sure.learn(fit_of(sure, {6.0, 0.0, 0.0}, 4.0 * kI, 0.0),
               [](const Eigen::Vector3d&, const Eigen::Matrix3d&) { return false; });
    EXPECT_LT(sure.mean().x(), 5.0);
}

TEST(SlowBelief, does_not_follow_what_leaps) {
    Belief belief = belief_of();
    for (int i = 0; i < 20; ++i) learn(belief, Eigen::Vector3d::Zero(), 4.0 * kI, 1.0);
    const Eigen::Vector3d before = belief.mean();
    learn(belief, {0.0, 0.0, 6.0}, 25.0 * kI, 1.0);
    EXPECT_EQ(belief.mean(), before);
}

TEST(SlowBelief, returns_to_what_was_promised_when_nothing_is_seen) {
    Belief belief = belief_of();
    for (int i = 0; i < 50; ++i) learn(belief, {1.0, 0.0, 0.0}, 11.0 * kI, 1.0);
    EXPECT_GT(belief.mean().x(), 0.5);
    belief.wait(400.0);
    EXPECT_LT(belief.mean().x(), 1e-3);
    EXPECT_TRUE(belief.covariance().isApprox(belief_of().covariance(), 1e-3));
}

TEST(SlowBelief, goes_on_from_what_was_saved) {
    Belief belief = belief_of(), again = belief_of();
    learn(belief, {1.0, 0.0, 0.0}, 11.0 * kI, 0.5);
    double state[Belief::kStateSize];
    belief.save(state);
    again.load(state);
    EXPECT_EQ(again.mean(), belief.mean());
    EXPECT_EQ(again.covariance(), belief.covariance());
}

}  // namespace
}  // namespace atropos::tracker
