#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/world.hpp"
#include "tests/sim/surfaces.hpp"

namespace atropos::sim {
namespace {

using Eigen::Vector3d;

TEST(Drape, hangs_limp_thread_down_both_sides_of_a_post) {
    World world;
    InstrumentOptions post;
    post.name = "post";
    const double radius = 5e-3;
    post.links = {{{Vector3d(0, -0.05, 0), Vector3d(0, 0.05, 0), radius}}};
    post.friction = 0.3;
    world.set_link_poses(world.add_instrument(post), std::vector{Eigen::Isometry3d::Identity()});
    ThreadOptions options;
    options.length_m = 0.07;
    options.edges = 140;
    options.material.EI_N_m2 = options.material.GJ_N_m2 = 0.0;
    const double r = radius + 0.5 * options.diameter_m, half = 0.5 * options.length_m;
    world.add_thread({{Vector3d(-half, 0, r), Vector3d(half, 0, r)}}, options);
    const double speed_m_s = world.settle(20.0);
    const ThreadTruth truth = world.thread();
    const double side = half - 0.5 * M_PI * r;  // what hangs on each side, straight down
    const Vector3d left = truth.sample(0, 0.0), right = truth.sample(0, options.length_m);
    const double weight_N_m =
        options.material.density_kg_m3 * M_PI * 0.25 * options.diameter_m * options.diameter_m * 9.81;
    const double tension_N = truth.tension_N(0, 0.5 * side);
    std::printf(
        "draped over a post: ends at %.4f, %.4f and %.4f, %.4f mm, expected -+%.4f, %.4f; tension %.4f "
        "of theory, at %.1e m/s\n",
        1e3 * left.x(), 1e3 * left.z(), 1e3 * right.x(), 1e3 * right.z(), 1e3 * r, -1e3 * side,
        tension_N / (0.5 * side * weight_N_m), speed_m_s);
    // Friction may hold one side a little longer than the other; together they are what the arc leaves.
    EXPECT_NEAR(0.5 * (left.z() + right.z()), -side, 2e-5);
    EXPECT_NEAR(left.z(), right.z(), 1e-3);
    EXPECT_NEAR(left.x(), -r, 2e-5);
    EXPECT_NEAR(right.x(), r, 2e-5);
    EXPECT_NEAR(tension_N / (0.5 * side * weight_N_m), 1.0, 0.02);
    EXPECT_LT(speed_m_s, 1e-3);
}

TEST(Drape, lies_on_hilly_tissue_without_sinking_in_or_floating) {
    World world;
    const auto height = [](double x, double y) {
        return 0.002 * std::cos(180 * x) * std::cos(120 * y) + 4 * (x * x + y * y);
    };
    const scenes::TriangleMesh mesh = testing::height_field(0.045, 60, height);
    world.add_tissue(mesh);
    scenes::Polyline wave;
    for (int i = 0; i <= 200; ++i)
        wave.points.push_back({-0.03 + 0.0003 * i, 0.006 * std::sin(0.08 * i), 0.012});
    world.add_thread(wave);
    for (int i = 0; i < 2000; ++i) world.step();
    const ThreadTruth before = world.thread();
    world.step();
    const ThreadTruth truth = world.thread();
    const Strand& strand = truth.strands[0];
    double lowest = 1.0, highest = 0.0, fastest = 0.0;
    int on_tissue = 0;
    const int samples = 500;
    for (int i = 0; i <= samples; ++i) {
        const double s = strand.s_m.back() * i / samples;
        const Vector3d p = truth.sample(0, s);
        const double clearance = testing::height_above(mesh, p) - truth.radius_m;
        lowest = std::min(lowest, clearance);
        highest = std::max(highest, clearance);
        on_tissue += clearance < 2e-5 ? 1 : 0;
        fastest = std::max(fastest, (p - before.sample(0, s)).norm() / 1e-3);
    }
    std::printf("draped over hills: clearance %.4f to %.3f mm, on tissue %.0f %%, fastest %.4f mm/s\n",
                1e3 * lowest, 1e3 * highest, 100.0 * on_tissue / samples, 1e3 * fastest);
    EXPECT_GT(lowest, -1e-5);
    EXPECT_LT(fastest, 1e-3);
    EXPECT_GT(on_tissue, 0);
}

}  // namespace
}  // namespace atropos::sim
