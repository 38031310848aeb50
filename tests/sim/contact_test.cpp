#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/world.hpp"
#include "tests/sim/surfaces.hpp"

namespace atropos::sim {
namespace {

using Eigen::Vector3d;

scenes::Polyline line(const Vector3d& a, const Vector3d& b) {
    return scenes::Polyline{{a, b}}.resampled(101);
}

double slid_mm(double slope_over_friction) {
    const double friction = 0.3, angle = std::atan(slope_over_friction * friction);
    World world;
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = Eigen::AngleAxisd(angle, Vector3d::UnitY()).toRotationMatrix();
    world.add_tissue(testing::height_field(0.1, 4, [](double, double) { return 0.0; }), X,
                     {"slope", friction});
    ThreadOptions options;
    // On the slope's own axes, or the thread would begin with a fall.
    const Vector3d start = X * Vector3d(0.001, 0, 0.5 * options.diameter_m);
    world.add_thread(line(start - Vector3d(0, 0.035, 0), start + Vector3d(0, 0.035, 0)), options);
    for (int i = 0; i < 500; ++i) world.step();
    const ThreadTruth truth = world.thread();
    return 1e3 * (truth.sample(0, 0.035) - start).norm();
}

TEST(Contact, slips_on_a_slope_at_the_angle_of_friction) {
    const double below = slid_mm(0.97), above = slid_mm(1.03);
    std::printf("slope: slid %.4f mm at 0.97, %.2f mm at 1.03 of tan = mu in 0.5 s\n", below, above);
    EXPECT_LT(below, 0.05);
    EXPECT_GT(above, 3.0);
}

TEST(Contact, multiplies_tension_over_a_cylinder_as_the_capstan_does) {
    const double radius = 5e-3, friction = 0.2;
    World world;
    InstrumentOptions post;
    post.name = "post";
    post.links = {{{Vector3d(0, -0.05, 0), Vector3d(0, 0.05, 0), radius}}};
    post.friction = friction;
    world.set_link_poses(world.add_instrument(post), std::vector{Eigen::Isometry3d::Identity()});
    InstrumentOptions puller;
    puller.name = "puller";
    puller.jaws = JawGeometry{};
    puller.jaws->hold_force_N = 100.0;
    const int hand = world.add_instrument(puller);
    ThreadOptions options;
    const double r = radius + 0.5 * options.diameter_m, drop = 0.02;
    scenes::Polyline curve;
    for (int i = 0; i < 40; ++i) curve.points.push_back({-r, 0, -drop * (1 - i / 40.0)});
    for (int i = 0; i <= 120; ++i)
        curve.points.push_back({-r * std::cos(M_PI * i / 120), 0, r * std::sin(M_PI * i / 120)});
    for (int i = 1; i <= 40; ++i) curve.points.push_back({r, 0, -drop * i / 40.0});
    const double length = curve.length_m();
    world.add_thread(curve, options);
    Eigen::Isometry3d X_WG = Eigen::Isometry3d::Identity();
    X_WG.translation() = Vector3d(r, 0, -drop);
    world.set_jaws(hand, X_WG, 0.0);
    world.anchor(0.0, {-r, 0, -drop});
    world.hold(hand, length, -Vector3d::UnitZ());
    for (int i = 0; i < 300; ++i) {
        X_WG.translation().z() -= 2e-6;
        world.set_jaws(hand, X_WG, 0.0);
        world.step();
    }
    const ThreadTruth truth = world.thread();
    const double slack = truth.tension_N(0, 0.2 * drop), tight = truth.tension_N(0, length - 0.2 * drop);
    std::printf("capstan: %.4f N over %.4f N = %.4f, theory %.4f\n", tight, slack, tight / slack,
                std::exp(M_PI * friction));
    EXPECT_NEAR(tight / slack / std::exp(M_PI * friction), 1.0, 0.05);
    EXPECT_GT(world.contact_force_N(0), 0.1);
}

void comes_to_rest_on(const scenes::TriangleMesh& mesh, const scenes::Polyline& start, const char* name) {
    World world;
    world.add_tissue(mesh);
    world.add_thread(start);
    for (int i = 0; i < 1500; ++i) world.step();
    const ThreadTruth before = world.thread();
    world.step();
    const ThreadTruth truth = world.thread();
    double fastest = 0.0, lowest = 1.0;
    for (size_t i = 0; i < truth.strands[0].p_W.size(); ++i) {
        fastest = std::max(fastest, (truth.strands[0].p_W[i] - before.strands[0].p_W[i]).norm() / 1e-3);
        lowest = std::min(lowest, testing::height_above(mesh, truth.strands[0].p_W[i]) - truth.radius_m);
    }
    std::printf("%s: lowest node %.5f mm above contact, fastest %.4f mm/s\n", name, 1e3 * lowest,
                1e3 * fastest);
    EXPECT_GT(lowest, -1e-5);
    EXPECT_LT(fastest, 1e-3);
}

TEST(Contact, comes_to_rest_on_a_box) {
    comes_to_rest_on(testing::box(0.06, 0.02), line({-0.035, 0.003, 0.004}, {0.035, -0.002, 0.003}), "box");
}

TEST(Contact, comes_to_rest_in_a_concave_mesh) {
    const auto bowl =
        testing::height_field(0.05, 40, [](double x, double y) { return 6.0 * (x * x + y * y); });
    comes_to_rest_on(bowl, line({-0.033, 0.004, 0.014}, {0.033, -0.004, 0.014}), "bowl");
}

}  // namespace
}  // namespace atropos::sim
