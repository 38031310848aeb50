#include <gtest/gtest.h>

#include <cmath>

#include "scenes/random_stream.hpp"
#include "sim/hanging_curve.hpp"
#include "tests/sim/rod_support.hpp"

namespace atropos::sim {
namespace {

using Eigen::Vector3d;
using testing::come_to_rest;
using testing::sampled;
using testing::with_length;

constexpr double kLength = 0.07;

Rod pinned_rod(int edges, double span, double EI, Boundary& ends) {
    RodParameters parameters;
    parameters.EI_N_m2 = EI;
    const Vector3d end(span, 0, 0);
    const auto curve = hanging_curve({Vector3d::Zero(), {1, 0, -1}}, {end, {1, 0, 1}}, kLength);
    Rod rod(with_length(state_along(curve.resampled(edges + 1).points), kLength), parameters);
    ends = {{{0, Vector3d::Zero()}, {edges, end}}, {}};
    come_to_rest(rod, ends);
    return rod;
}

TEST(Rod, keeps_its_length_while_it_is_carried) {
    for (const double speed : {0.05, 0.15}) {
        Boundary ends;
        Rod rod = pinned_rod(100, 0.06, 1e-8, ends);
        const Vector3d a = ends.nodes[0].p_W, b = ends.nodes[1].p_W;
        std::vector<SurfaceContact> none;
        double worst_total = 0.0, worst_edge = 0.0;
        const double amplitude = 0.02, rate = speed / (amplitude * 1.62);  // of the path's peak speed
        for (int i = 1; i <= 1000; ++i) {
            const double u = rate * i * 1e-3;
            const Vector3d path(amplitude * std::sin(u), amplitude * std::sin(0.8 * u),
                                amplitude * (1 - std::cos(u)));
            ends.nodes[0].p_W = a + path;
            ends.nodes[1].p_W = b + path;
            rod.step(1e-3, ends, none);
            double total = 0.0;
            for (int e = 0; e < 100; ++e) {
                total += rod.tension_N(e) / rod.parameters().EA_N / 100;
                worst_edge = std::max(worst_edge, std::abs(rod.tension_N(e) / rod.parameters().EA_N));
            }
            worst_total = std::max(worst_total, std::abs(total));
        }
        std::printf("carried at %g m/s: length error %.2e, edge %.2e\n", speed, worst_total, worst_edge);
        EXPECT_LT(worst_total, 1e-4);
        EXPECT_LT(worst_edge, 1e-3);
    }
}

TEST(Rod, never_gains_energy_when_nothing_drives_it) {
    RodParameters parameters;
    parameters.drag_N_s_m2 = 0.0;
    parameters.self_contact = false;
    parameters.tolerance_m = 1e-10;
    const double edge = kLength / 100;
    Rod rod(sampled(100, [](double u) { return Vector3d(kLength * u, 0, 0); }), parameters);
    Boundary clamp{{{0, {0, 0, 0}}, {1, {edge, 0, 0}}}, {}};
    std::vector<SurfaceContact> none;
    double before = rod.energy_J(clamp), peak = 0.0, worst = -1.0;
    const double lowest = before - rod.mass_kg() * 9.81 * kLength;
    for (int i = 0; i < 1000; ++i) {
        rod.step(1e-3, clamp, none);
        const double now = rod.energy_J(clamp);
        peak = std::max(peak, now - lowest);
        worst = std::max(worst, now - before);
        before = now;
    }
    std::printf("largest rise of energy in a step over its peak: %.2e\n", worst / peak);
    EXPECT_LT(worst, 1e-9 * peak);
}

TEST(Rod, keeps_length_mass_and_momentum_through_cuts) {
    scenes::RandomStream random(7, "cuts");
    for (int trial = 0; trial < 10; ++trial) {
        Boundary ends;
        Rod rod = pinned_rod(100, 0.05, 1e-8, ends);
        std::vector<SurfaceContact> none;
        for (int i = 0; i < 20; ++i) {
            for (auto& n : ends.nodes) n.p_W += Vector3d(5e-5, 5e-5, 0);
            rod.step(1e-3, ends, none);
        }
        const bool on_node = trial == 0;
        const int edge = on_node ? 40 : 2 + static_cast<int>(random.integer(96));
        const double t = on_node ? 0.0 : random.uniform(0.05, 0.95);
        const double mass = rod.mass_kg();
        const Vector3d momentum = rod.momentum_kg_m_s();
        rod.cut(edge, t);
        const ThreadState& state = rod.state();
        double first = 0.0, second = 0.0;
        bool past = false;
        for (int i = 0; i < state.edge_count(); ++i) {
            if (!state.has_edge(i))
                past = true;
            else
                (past ? second : first) += state.rest_length_m(i);
        }
        EXPECT_NEAR(first, (edge + t) * kLength / 100, 1e-12 * kLength);
        EXPECT_NEAR(first + second, kLength, 1e-12 * kLength);
        EXPECT_NEAR(rod.mass_kg(), mass, 1e-12 * mass);
        EXPECT_LT((rod.momentum_kg_m_s() - momentum).norm(), 1e-12 * momentum.norm());
        ends.nodes[1].node = state.node_count() - 1;
        double strain = 0.0;
        for (int i = 0; i < 2000; ++i) {
            rod.step(1e-3, ends, none);
            for (int e = 0; e < state.edge_count(); ++e)
                strain = std::max(strain, std::abs(rod.tension_N(e)) / rod.parameters().EA_N);
        }
        for (const auto& p : state.p_W) ASSERT_TRUE(p.allFinite());
        EXPECT_LT(strain, 1e-4) << "trial " << trial;
    }
}

/// Middle of a thread at rest, clamped at 30 degrees at both ends, after it swung for a second and was let
/// down.
Vector3d rest_shape(int edges, double dt_s, double at) {
    RodParameters parameters;
    const double edge = kLength / edges;
    const Vector3d d0(std::sqrt(0.75), 0, -0.5), d1(std::sqrt(0.75), 0, 0.5), end(0.05, 0, 0);
    // Two fixed nodes clamp the middle of their edge: that point and the length between are the same on each
    // mesh.
    const Vector3d h0 = 0.5 * edge * d0, h1 = 0.5 * edge * d1;
    const auto curve = hanging_curve({-h0, d0}, {end + h1, d1}, kLength + edge);
    Rod rod(with_length(state_along(curve.resampled(edges + 2).points), kLength + edge), parameters);
    Boundary clamps{{{0, -h0}, {1, h0}, {edges, end - h1}, {edges + 1, end + h1}}, {}};
    testing::run(rod, clamps, 0.5, dt_s);
    come_to_rest(rod, clamps, 1e-6, 60.0, dt_s);
    const auto i = static_cast<size_t>(std::lround(at * edges));
    return 0.5 * (rod.state().p_W[i] + rod.state().p_W[i + 1]);
}

TEST(Rod, rests_in_the_same_shape_for_every_step_and_mesh) {
    const Vector3d reference[] = {rest_shape(200, 1e-3, 0.3), rest_shape(200, 1e-3, 0.5)};
    const std::pair<int, double> ladder[] = {{50, 1e-3}, {100, 2e-3}, {100, 1e-3}, {100, 5e-4}};
    for (const auto& [edges, dt] : ladder)
        for (int k = 0; k < 2; ++k) {
            const double error = (rest_shape(edges, dt, k == 0 ? 0.3 : 0.5) - reference[k]).norm();
            std::printf("%d edges, %g s, s = %g L: %.4f mm from 200 edges\n", edges, dt, k == 0 ? 0.3 : 0.5,
                        1e3 * error);
            EXPECT_LT(error, 5e-5);
        }
}

}  // namespace
}  // namespace atropos::sim
