#include "sim/world.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/derived_physics.hpp"
#include "tests/sim/world_support.hpp"

namespace atropos::sim {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using testing::HeldThread;
using ::testing::Not;

TEST(World, holds_a_thread_at_rest_between_two_jaws) {
    HeldThread held;
    const ThreadTruth before = held.world.thread();
    for (int i = 0; i < 200; ++i) held.world.step();
    const ThreadTruth after = held.world.thread();
    ASSERT_EQ(after.strands.size(), 1u);
    double moved = 0.0;
    for (size_t i = 0; i < after.strands[0].p_W.size(); ++i)
        moved = std::max(moved, (after.strands[0].p_W[i] - before.strands[0].p_W[i]).norm());
    EXPECT_LT(moved, 1e-6);
    EXPECT_LT(after.sample(0, 0.035).z(), -0.01);
    EXPECT_NEAR(after.span.middle_s_m(), 0.035, 1e-12);
    const double weight = 1350 * M_PI * 0.125e-3 * 0.125e-3 * 0.07 * 9.81;
    EXPECT_NEAR((held.world.grip_force_W_N(0) + held.world.grip_force_W_N(1)).z(), -weight, 1e-3 * weight);
}

TEST(World, carries_the_thread_with_its_jaws) {
    HeldThread held;
    for (int i = 0; i < 500; ++i) {
        for (int k = 0; k < 2; ++k) {
            held.X_WG[k].translation() += Vector3d(0, 1e-4, 0);
            held.world.set_jaws(k, held.X_WG[k], 0.0);
        }
        held.world.step();
    }
    const ThreadTruth truth = held.world.thread();
    EXPECT_NEAR(truth.sample(0, truth.span.s0_m).y(), 0.05, 1e-6);
}

TEST(World, cuts_the_thread_where_the_blades_meet_it) {
    HeldThread held;
    const Vector3d middle = held.world.thread().sample(0, 0.0301);
    const Eigen::Isometry3d X_WS = HeldThread::frame(middle);
    for (int i = 0; i <= 60; ++i) {
        held.world.set_blades(2, X_WS, 0.6 * (1.0 - i / 60.0));
        held.world.step();
    }
    const auto& events = held.world.events();
    ASSERT_EQ(
        std::count_if(events.begin(), events.end(), [](const Event& e) { return e.kind == EventKind::kCut; }),
        1);
    EXPECT_EQ(held.world.thread().strands.size(), 2u);
    EXPECT_NEAR(events.back().s_m, 0.0301, 2e-4);
    for (int i = 0; i < 300; ++i) held.world.step();
    const ThreadTruth truth = held.world.thread();
    EXPECT_LT(truth.strands[0].p_W.back().z(), -0.003);
    EXPECT_GT((truth.strands[0].p_W.back() - truth.strands[1].p_W.front()).norm(), 0.004);
    EXPECT_FALSE(truth.span.intact);
}

TEST(World, swaps_the_rod_for_the_soft_rope_of_bullet) {
    ThreadOptions options;
    options.model = ThreadModel::kBulletSoft;
    HeldThread held(0.05, 0.07, options);
    const ThreadTruth before = held.world.thread();
    EXPECT_LT(before.sample(0, 0.035).z(), -0.01);
    EXPECT_GT(before.sample(0, 0.035).z(), -0.03);
    const Eigen::Isometry3d X_WS = HeldThread::frame(before.sample(0, 0.04));
    for (int i = 0; i <= 60; ++i) {
        held.world.set_blades(2, X_WS, 0.6 * (1.0 - i / 60.0));
        held.world.step();
    }
    ASSERT_EQ(held.world.thread().strands.size(), 2u);
    EXPECT_NEAR(held.world.events().back().s_m, 0.04, 3e-4);
}

TEST(DerivedPhysics, fits_bending_stiffness_to_a_sag) {
    const double density = 6.6e-5;
    for (const double EI : {3e-9, 1e-8, 3e-7})
        EXPECT_NEAR(fit_sag_EI(0.07, cantilever_sag_m(0.07, EI, density), density) / EI, 1.0, 1e-6);
    // Small sag: w L^4 / 8 EI.
    EXPECT_NEAR(cantilever_sag_m(0.07, 1e-5, density), density * 9.81 * std::pow(0.07, 4) / 8e-5, 1e-8);
    EXPECT_THROW(fit_sag_EI(0.07, 0.08, density), std::invalid_argument);
}

TEST(DerivedPhysics, warns_of_edges_that_cost_more_than_real_time) {
    const auto warnings = [](int edges) {
        ThreadOptions options;
        options.edges = edges;
        std::string all;
        for (const std::string& line : derived_physics(options).warnings) all += line + '\n';
        return all;
    };
    EXPECT_THAT(warnings(140), Not(HasSubstr("slower than real time")));
    EXPECT_THAT(warnings(300), HasSubstr("a knot drawn tight with 300 edges is slower than real time"));
    EXPECT_THAT(warnings(300), Not(HasSubstr("\n300 edges are")));
    EXPECT_THAT(warnings(900), HasSubstr("900 edges are slower than real time"));
}

TEST(DerivedPhysics, knows_the_gravity_bending_length) {
    const DerivedPhysics p = derived_physics(ThreadOptions{});
    EXPECT_NEAR(p.gravity_bending_length_m, 0.025, 1e-3);
    EXPECT_NEAR(p.strain_at_1_N, 0.002342, 2e-5);
    EXPECT_FALSE(p.warnings.empty());
}

}  // namespace
}  // namespace atropos::sim
