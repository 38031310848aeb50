#include "tracker/energy.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>

#include "scenes/random_stream.hpp"
#include "tests/support/scalar_energy.hpp"
#include "tests/support/tracking_trial.hpp"
#include "tracker/chain_dp.hpp"
#include "tracker/chain_icm.hpp"
#include "tracker/label_set.hpp"
#include "tracker/stereo_cost_images.hpp"
#include "tracker/thread_initialiser.hpp"

namespace atropos::tracker {
namespace {

scenes::StereoRig distorted_converging_rig() {
    scenes::StereoRig rig = scenes::parallel_rig(640, 360, 575.0, 0.005);
    rig.left.distortion = {-0.25, 0.08, 0.001, -0.0005, 0.01, 0.02, 0.0, 0.0};
    rig.right.distortion = {-0.23, 0.07, -0.001, 0.0007, 0.0, 0.0, 0.0, 0.0};
    rig.X_RC.linear() = Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitY()).toRotationMatrix();
    return rig;
}

/// A curve a little beside the thread of a rendered frame, with all that the energies need.
struct Scene {
    explicit Scene(const scenes::StereoRig& rig, std::uint64_t seed = 5)
        : eyes(make_eyes(rig)), sampling(3, 8, 60), images(scenes::TrackerConfig{}, {0.9, 1.35}, 15) {
        const support::SyntheticSequence sequence({.seed = seed, .rig = rig});
        const support::SyntheticFrame drawn = sequence.frame(0);
        const StereoFrame frame = support::stereo_frame(drawn, 0);
        images.make(frame, pool);
        control_points = fit_curve(drawn.truth_C, {.length_weight = 1.0}).control_points();
        scenes::RandomStream random(seed, "shift");
        for (int j = 0; j < sampling.samples(); ++j)
            speeds.push_back(sampling.velocity(control_points, j).norm() * random.uniform(0.9, 1.1));
        for (Eigen::Vector3d& q : control_points)
            q += 0.0005 * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
        tips = frame.tips;
    }
    EnergyContext context() const {
        return {sampling, eyes, images.costs(), speeds, tips, {.length = 50.0, .smooth_per_m = 20.0}};
    }
    NodeLabels labels(int r, double s_m) const {
        const std::vector<Eigen::Vector3d> set = label_set(r, s_m);
        NodeLabels labels(8, static_cast<int>(set.size()));
        for (int k = 0; k < 8; ++k) labels.set(k, set, eyes);
        return labels;
    }

    std::array<Eye, 2> eyes;
    CurveSampling sampling;
    mutable scenes::WorkerPool pool{1};
    StereoCostImages images;
    std::vector<Eigen::Vector3d> control_points;
    std::vector<double> speeds;
    std::array<std::optional<MeasuredTip>, 2> tips;
};

TEST(Eye, sees_every_point_where_the_rig_projects_it) {
    const scenes::StereoRig rig = distorted_converging_rig();
    const std::array<Eye, 2> eyes = make_eyes(rig);
    scenes::RandomStream random(2, "points");
    for (int i = 0; i < 100; ++i) {
        const Eigen::Vector3d p_C(random.uniform(-0.04, 0.04), random.uniform(-0.02, 0.02),
                                  random.uniform(0.08, 0.12));
        EXPECT_NEAR((eyes[0].pixel(eyes[0].homogeneous(p_C)) - rig.project_left(p_C)).norm(), 0.0, 1e-10);
        EXPECT_NEAR((eyes[1].pixel(eyes[1].homogeneous(p_C)) - rig.project_right(p_C)).norm(), 0.0, 1e-10);
    }
}

TEST(Energy, of_a_stretched_line_over_empty_images_is_what_its_equations_say) {  // eq. 4-7 and 19
    Scene scene(scenes::parallel_rig(640, 360, 575.0, 0.005));
    StereoFrame empty;
    empty.left = empty.right = cv::Mat1b(360, 640, std::uint8_t{90});
    scene.images.make(empty, scene.pool);
    const Eigen::Vector3d from(-0.02, 0.0, 0.1), to(0.02, 0.01, 0.11);
    scene.control_points = straight_line(3, 8, from, to);
    scene.speeds.assign(scene.speeds.size(), (to - from).norm() / 1.1);
    scene.tips = {MeasuredTip{.p_C = from + Eigen::Vector3d(0.0, 0.003, 0.004)}, MeasuredTip{.p_C = to}};
    const EnergyTerms found = energy(scene.context(), scene.control_points);
    EXPECT_NEAR(found.data, 15.0, 1e-5);     // both eyes' truncation, halved and summed
    EXPECT_NEAR(found.length, 0.01, 1e-12);  // a tenth too long everywhere
    EXPECT_NEAR(found.tips, 20000.0 * 0.005, 1e-9);
    EXPECT_NEAR(found.total, 15.0 + 50.0 * 0.01 + 100.0, 1e-5);
}

TEST(CurveSampling, weights_sum_to_one_at_every_sample) {  // eq. 14 and 18
    for (int K = 4; K <= 20; K += 4) {
        const CurveSampling sampling(3, K, 60);
        for (int j = 0; j < 60; ++j) {
            double nodes = 0.0;
            double pairs = 0.0;
            for (int p = 0; p < K; ++p) nodes += sampling.alpha(p, j);
            for (int p = 0; p + 1 < K; ++p) pairs += sampling.alpha_pair(p, j);
            EXPECT_NEAR(nodes, 1.0, 1e-13);
            EXPECT_NEAR(pairs, 1.0, 1e-13);
        }
    }
}

TEST(Potentials, of_both_kinds_are_the_energy_when_nothing_moves) {
    for (const scenes::StereoRig& rig :
         {scenes::parallel_rig(640, 360, 575.0, 0.005), distorted_converging_rig()}) {
        const Scene scene(rig);
        const NodeLabels labels = scene.labels(2, 0.0008);
        const double E = energy(scene.context(), scene.control_points).total;
        ChainProblem chain(8, labels.labels());
        const std::vector<int> at_rest(8, 0);
        PotentialsE1().fill(scene.context(), scene.control_points, labels, scene.pool, chain);
        EXPECT_NEAR(chain.cost(at_rest), E, 1e-4 * E);
        PotentialsE2().fill(scene.context(), scene.control_points, labels, scene.pool, chain);
        EXPECT_NEAR(chain.cost(at_rest), E, 1e-4 * E);
    }
}

TEST(Potentials, equal_the_plain_scalar_ones) {
    for (const scenes::StereoRig& rig :
         {scenes::parallel_rig(640, 360, 575.0, 0.005), distorted_converging_rig()}) {
        const Scene scene(rig);
        const NodeLabels labels = scene.labels(1, 0.0012);
        ChainProblem fast(8, labels.labels());
        ChainProblem plain(8, labels.labels());
        const auto compare = [&](Potentials& one, Potentials& other) {
            one.fill(scene.context(), scene.control_points, labels, scene.pool, fast);
            other.fill(scene.context(), scene.control_points, labels, scene.pool, plain);
            for (int p = 0; p < 8; ++p)
                for (int l = 0; l < labels.labels(); ++l) {
                    const std::size_t i = static_cast<std::size_t>(l);
                    ASSERT_NEAR(fast.unary(p)[i], plain.unary(p)[i], 2e-3);
                    for (int m = 0; p < 7 && m < labels.labels(); ++m) {
                        const std::size_t pair =
                            i * static_cast<std::size_t>(fast.stride()) + static_cast<std::size_t>(m);
                        ASSERT_NEAR(fast.pairwise(p)[pair], plain.pairwise(p)[pair], 2e-3);
                    }
                }
        };
        PotentialsE1 e1;
        support::ScalarPotentialsE1 scalar_e1;
        compare(e1, scalar_e1);
        PotentialsE2 e2;
        support::ScalarPotentialsE2 scalar_e2;
        compare(e2, scalar_e2);
    }
}

TEST(Potentials, of_images_are_minimised_no_worse_than_by_iterated_conditional_modes) {
    ChainDp dp;
    ChainIcm icm;
    scenes::WorkerPool pool(1);
    int problems = 0;
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
        Scene scene(scenes::parallel_rig(320, 180, 287.5, 0.005), seed);
        for (int i = 0; i < 125; ++i)
            for (const bool second : {false, true}) {
                const NodeLabels labels = scene.labels(1, 0.0003 * (1 + i % 5));
                ChainProblem chain(8, labels.labels());
                if (second)
                    PotentialsE2().fill(scene.context(), scene.control_points, labels, pool, chain);
                else
                    PotentialsE1().fill(scene.context(), scene.control_points, labels, pool, chain);
                std::vector<int> exact(8);
                std::vector<int> local(8);
                const double best = dp.minimise(chain, exact);
                ASSERT_LE(best, icm.minimise(chain, local) + 1e-5);
                scene.control_points[static_cast<std::size_t>(i % 8)].x() += 0.0002;
                ++problems;
            }
    }
    EXPECT_EQ(problems, 1000);
}

TEST(Potentials, are_the_same_bytes_for_any_number_of_threads) {
    const Scene scene(scenes::parallel_rig(640, 360, 575.0, 0.005));
    const NodeLabels labels = scene.labels(2, 0.0008);
    ChainProblem one(8, labels.labels());
    PotentialsE2().fill(scene.context(), scene.control_points, labels, scene.pool, one);
    for (const int threads : {2, 3, 7}) {
        scenes::WorkerPool pool(threads);
        ChainProblem many(8, labels.labels());
        PotentialsE2().fill(scene.context(), scene.control_points, labels, pool, many);
        for (int p = 0; p < 7; ++p)
            ASSERT_TRUE(std::equal(one.pairwise(p).begin(), one.pairwise(p).end(), many.pairwise(p).begin()));
    }
}

TEST(TipDistance, is_free_up_to_epsilon) {  // eq. 19
    EXPECT_EQ(tip_distance({0.0003, 0.0, 0.0004}, 0.0005), 0.0);
    EXPECT_DOUBLE_EQ(tip_distance({0.003, 0.0, 0.004}, 0.0005), 0.005);
}

TEST(LabelSet, samples_a_cube_in_seven_directions) {  // II-D3, fig. 3(b)
    for (int r = 1; r <= 4; ++r) {
        const std::vector<Eigen::Vector3d> labels = label_set(r, 0.001);
        ASSERT_EQ(labels.size(), static_cast<std::size_t>(14 * r + 1));
        EXPECT_EQ(labels.front().norm(), 0.0);
        double reach = 0.0;
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (const Eigen::Vector3d& l : labels) {
            reach = std::max(reach, l.cwiseAbs().maxCoeff());
            sum += l;
            EXPECT_EQ(std::count(labels.begin(), labels.end(), l), 1);
        }
        EXPECT_NEAR(reach, 0.001 * r, 1e-15);
        EXPECT_NEAR(sum.norm(), 0.0, 1e-15);
    }
}

TEST(LabelSet, of_table_1_reaches_14_px_of_640) {
    scenes::TrackerConfig config;
    config.labels.preset = scenes::LabelPreset::kPaperTable1;
    for (const int width : {640, 1920}) {
        const scenes::StereoRig rig = scenes::parallel_rig(width, width * 9 / 16, 0.9 * width, 0.005);
        const double s_m = label_spacing_m(config, rig, 0.1);
        EXPECT_NEAR(config.labels.r * 1.5 * s_m / rig.m_per_px(0.1), 14.0 * width / 640.0, 1e-9);
    }
}

TEST(LabelSet, along_rays_moves_depth_without_moving_the_image) {
    const scenes::StereoRig rig = scenes::parallel_rig(640, 360, 575.0, 0.005);
    const Eigen::Vector3d p(0.02, -0.01, 0.1);
    const Eigen::Matrix3d axes = ray_axes(p, 4.0);
    EXPECT_NEAR((rig.project_left(p + 0.001 * axes.col(2)) - rig.project_left(p)).norm(), 0.0, 1e-9);
    EXPECT_NEAR(axes.col(2).norm(), 4.0, 1e-12);
    EXPECT_NEAR((axes.leftCols<2>().transpose() * axes.leftCols<2>() - Eigen::Matrix2d::Identity()).norm(),
                0.0, 1e-12);
}

}  // namespace
}  // namespace atropos::tracker
