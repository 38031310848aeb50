#include "tests/sim/knot.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/sim/knot_curves.hpp"
#include "tests/sim/rod_support.hpp"

namespace atropos::sim {
namespace {

using Eigen::Vector3d;

const Vector3d kView(0.1, 0.2, 1.0);

struct Pull {
    double diameter_mm, EI_N_m2, force_N;
};

struct Tightened {
    int determinant_before, determinant_after;
    double penetration;  // largest, in diameters
    double tension_N, thread_used_mm;
    int contacts;
};

double closest_diameters(const Rod& rod) {
    const double d = rod.parameters().diameter_m;
    double closest = 2.0;
    for (const EdgePair& pair : near_edge_pairs(rod.state(), rod.state().p_W, d, 2 * d))
        closest = std::min(closest, edge_approach(rod.state().p_W, pair).distance_m / d);
    return closest;
}

/// Lets the prepared knot come free of strain under heavy drag, parts its ends at 40 mm/s up to the force and
/// holds it for half a second.
Tightened tighten(const scenes::Polyline& curve, int edges, const Pull& pull, std::vector<int> fixed) {
    const double length = curve.length_m(), d = 1e-3 * pull.diameter_mm;
    const ThreadState state = testing::with_length(state_along(curve.resampled(edges + 1).points), length);
    RodParameters parameters;
    parameters.diameter_m = d;
    parameters.EI_N_m2 = pull.EI_N_m2;
    parameters.GJ_N_m2 = 0.75 * pull.EI_N_m2;
    parameters.EA_N = 8.7e9 * M_PI * d * d / 4;
    parameters.linear_density_kg_m = 1350 * M_PI * d * d / 4;
    parameters.gravity_W_m_s2.setZero();
    Rod rod(state, parameters);
    Tightened result{testing::knot_determinant(state.p_W, kView), 0, 0.0, 0.0, 0.0, 0};
    Boundary ends{{{0, state.p_W.front()}, {edges, state.p_W.back()}}, {}};
    for (const int node : fixed) ends.nodes.push_back({node, state.p_W[static_cast<size_t>(node)]});
    rod.parameters().drag_N_s_m2 = 2e-2;
    testing::run(rod, ends, 0.3);
    rod.parameters().drag_N_s_m2 = parameters.drag_N_s_m2;
    const Vector3d apart = 2e-5 * (state.p_W.back() - state.p_W.front()).normalized();
    const auto step = [&] {
        testing::run(rod, ends, 1e-3);
        result.penetration = std::max(result.penetration, 1.0 - closest_diameters(rod));
    };
    const auto tension = [&] { return 0.5 * (rod.tension_N(1) + rod.tension_N(edges - 2)); };
    for (int i = 0; i < 3000 && tension() < pull.force_N; ++i) {
        ends.nodes[0].p_W -= apart;
        ends.nodes[1].p_W += apart;
        step();
    }
    EXPECT_GE(tension(), pull.force_N);
    for (int i = 0; i < 500; ++i) step();
    result.tension_N = tension();
    result.contacts = rod.report().self_contacts;
    result.thread_used_mm = 1e3 * (length - (rod.state().p_W.back() - rod.state().p_W.front()).norm());
    result.determinant_after = testing::knot_determinant(rod.state().p_W, kView);
    return result;
}

TEST(KnotDeterminant, tells_knots_apart) {
    EXPECT_EQ(testing::knot_determinant(testing::loose_overhand(0.07).points, kView), 3);
    EXPECT_EQ(testing::knot_determinant(testing::loose_square_knot(1e-3).points, kView), 9);
    std::vector<Vector3d> bend;
    for (int i = 0; i <= 100; ++i) bend.push_back({std::cos(0.05 * i), std::sin(0.05 * i), 0.01 * i});
    EXPECT_EQ(testing::knot_determinant(bend, kView), 1);
}

class OverhandKnot : public ::testing::TestWithParam<Pull> {};

TEST_P(OverhandKnot, holds_when_pulled_tight) {
    const Pull& pull = GetParam();
    const Tightened knot = tighten(testing::loose_overhand(0.07), 140, pull, {});
    std::printf(
        "overhand %.2f mm, EI %g, %g N: determinant %d -> %d, penetration %.1f %%, %.2f N after the hold, "
        "%.2f mm used, %d contacts\n",
        pull.diameter_mm, pull.EI_N_m2, pull.force_N, knot.determinant_before, knot.determinant_after,
        100 * knot.penetration, knot.tension_N, knot.thread_used_mm, knot.contacts);
    EXPECT_EQ(knot.determinant_before, 3);
    EXPECT_EQ(knot.determinant_after, 3);
    EXPECT_LT(knot.penetration, 0.05);
    EXPECT_GT(knot.tension_N, 0.5 * pull.force_N);
}

INSTANTIATE_TEST_SUITE_P(Diameters, OverhandKnot,
                         ::testing::Values(Pull{0.25, 1e-8, 1.0}, Pull{0.25, 1e-8, 3.0},
                                           Pull{0.30, 5e-8, 1.0}, Pull{0.30, 5e-8, 3.0},
                                           Pull{0.50, 5e-8, 1.0}, Pull{0.50, 5e-8, 3.0}));

struct LooseKnot {
    double thickness;  // diameter over the loop's radius
    double T_R2_EI;    // pull times radius squared over bending stiffness
};

/// An overhand knot without friction, 60 mm of 300 in its loop, at rest.
LooseKnot loose_overhand_at_rest(double diameter_m) {
    const int edges = 300;
    const double length = 0.3, used = 0.06, EI = 1e-8;
    const ThreadState state = testing::with_length(
        state_along(testing::loose_overhand(length).resampled(edges + 1).points), length);
    RodParameters parameters;
    parameters.diameter_m = diameter_m;
    parameters.EI_N_m2 = EI;
    parameters.self_friction = 0.0;
    parameters.gravity_W_m_s2.setZero();
    parameters.drag_N_s_m2 = 2e-2;
    Rod rod(state, parameters);
    Boundary ends{{{0, state.p_W.front()}, {edges, state.p_W.back()}}, {}};
    testing::run(rod, ends, 0.3);
    rod.parameters().drag_N_s_m2 = 2e-3;
    const Vector3d apart = (state.p_W.back() - state.p_W.front()).normalized();
    double span = (state.p_W.back() - state.p_W.front()).norm();
    for (; span < length - used; span += 4e-5) {
        ends.nodes[0].p_W -= 2e-5 * apart;
        ends.nodes[1].p_W += 2e-5 * apart;
        testing::run(rod, ends, 1e-3);
    }
    rod.parameters().max_newton_in_contact = 10;
    rod.parameters().contact_tolerance_m = 1e-8;
    testing::run(rod, ends, 0.5);
    const double radius = (length - span) / (2 * M_PI);
    const double pull = 0.5 * (rod.pull_on_node_N(0) - rod.pull_on_node_N(edges)).dot(apart);
    EXPECT_EQ(testing::knot_determinant(rod.state().p_W, kView), 3);
    return {diameter_m / radius, std::abs(pull) * radius * radius / EI};
}

TEST(LooseKnot, pulls_when_loose_and_smooth_by_the_law_of_thin_knots) {
    // Audoly, Clauvelin, Neukirch 2007: T R^2 / EI = 1/2 in the limit, approached from above.
    const LooseKnot thin = loose_overhand_at_rest(5e-5), thicker = loose_overhand_at_rest(2e-4);
    std::printf("loose overhand: T R^2/EI %.3f at d/R %.4f, %.3f at %.4f\n", thin.T_R2_EI, thin.thickness,
                thicker.T_R2_EI, thicker.thickness);
    EXPECT_NEAR(thin.T_R2_EI, 0.5, 0.05);
    EXPECT_GT(thicker.T_R2_EI, thin.T_R2_EI);
}

TEST(SquareKnot, holds_when_pulled_tight) {
    const scenes::Polyline curve = testing::loose_square_knot(0.7e-3);
    const int edges = 160;
    const Tightened knot = tighten(curve, edges, {0.25, 1e-8, 1.0}, {edges / 2});
    std::printf(
        "square knot: length %.1f mm, determinant %d -> %d, penetration %.1f %%, %.2f N after the hold, %d "
        "contacts\n",
        1e3 * curve.length_m(), knot.determinant_before, knot.determinant_after, 100 * knot.penetration,
        knot.tension_N, knot.contacts);
    EXPECT_EQ(knot.determinant_before, 9);
    EXPECT_EQ(knot.determinant_after, 9);
    EXPECT_LT(knot.penetration, 0.05);
}

}  // namespace
}  // namespace atropos::sim
