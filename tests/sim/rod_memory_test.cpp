// Thread that remembers a curve: natural curvature.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/elastica.hpp"
#include "tests/sim/rod_support.hpp"

namespace atropos::sim {
namespace {

using Eigen::Vector3d;
using testing::come_to_rest;
using testing::sampled;

constexpr double kLength_m = 0.07;

RodParameters curled(double curvature_per_m, double EI) {
    RodParameters p;
    p.EI_N_m2 = EI;
    p.GJ_N_m2 = 0.75 * EI;
    p.natural_curvature_per_m = curvature_per_m;
    return p;
}

/// Nearly straight along x, bent a little downwards, so that downwards is where it curls.
ThreadState nearly_straight(int edges) {
    return sampled(edges, [](double u) {
        return Vector3d(kLength_m * u, 0.0, u < 2e-2 ? 0.0 : -1e-4 * (u - 2e-2) * (u - 2e-2));
    });
}

TEST(RodMemory, has_a_gradient_that_agrees_with_differences) {
    const ThreadState state = sampled(
        12, [](double u) { return Vector3d(0.01 * std::cos(4 * u), 0.01 * std::sin(4 * u), 0.004 * u * u); });
    for (const bool held : {false, true}) {
        RodMemory memory;
        memory.reset(state, {80.0, 1e-8, 0.7e-8});
        std::vector<HeldRoll> rolls;
        if (held) {
            const Vector3d t = (state.p_W[1] - state.p_W[0]).normalized();
            rolls.push_back({0, 0, t.unitOrthogonal()});
        }
        memory.hold(state, rolls);
        std::vector<Vector3d> x = state.p_W;
        for (size_t i = 2; i < x.size(); ++i)
            x[i] += 2e-4 *
                    Vector3d(std::sin(3.0 * double(i)), std::cos(5.0 * double(i)), std::sin(7.0 * double(i)));
        Eigen::VectorXd gradient = Eigen::VectorXd::Zero(3 * static_cast<int>(x.size()));
        memory.add_gradient(state, x, gradient);
        double worst = 0.0;
        for (size_t i = held ? 2 : 0; i < x.size(); ++i)
            for (int k = 0; k < 3; ++k) {
                std::vector<Vector3d> plus = x, minus = x;
                plus[i][k] += 1e-7;
                minus[i][k] -= 1e-7;
                const double difference =
                    (memory.energy_J(state, plus) - memory.energy_J(state, minus)) / 2e-7;
                worst = std::max(worst, std::abs(difference - gradient[3 * static_cast<int>(i) + k]));
            }
        std::printf("gradient of memory, %s: off by %.1e of %.1e N\n", held ? "held" : "free", worst,
                    gradient.lpNorm<Eigen::Infinity>());
        EXPECT_LT(worst, 1e-5 * gradient.lpNorm<Eigen::Infinity>());
    }
}

TEST(RodMemory, curls_to_its_radius_when_free_and_weightless) {
    RodParameters parameters = curled(33.0, 3e-7);
    parameters.gravity_W_m_s2.setZero();
    Rod rod(nearly_straight(100), parameters);
    Boundary none;
    come_to_rest(rod, none, 1e-6);
    const auto& p = rod.state().p_W;
    const double chord = (p.back() - p.front()).norm(), radius = 1.0 / 33.0;
    const double expected = 2.0 * radius * std::sin(kLength_m / (2.0 * radius));
    std::printf("free curl: chord %.4f mm, theory %.4f\n", 1e3 * chord, 1e3 * expected);
    EXPECT_NEAR(1e3 * chord, 1e3 * expected, 0.01);
}

/// Tip error in mm against the elastica whose curvature at the free end is the natural one.
double curled_cantilever_error_mm(int edges, double EI, double curvature_per_m) {
    const double edge = kLength_m / edges;
    Rod rod(nearly_straight(edges), curled(curvature_per_m, EI));
    const Vector3d axis = rod.memory().curl_axis_W(0);
    Boundary clamp{{{0, {0, 0, 0}}, {1, {edge, 0, 0}}}, {}, {{0, 0, axis}}};
    come_to_rest(rod, clamp);
    const double w = rod.parameters().linear_density_kg_m * 9.81, free = kLength_m - edge / 2;
    double low = -w * free * free / EI - 2.0 * curvature_per_m, high = 0.0;
    for (int i = 0; i < 100; ++i) {
        const double k = 0.5 * (low + high);
        const double at_end = testing::integrate_elastica(EI, 0, w, free, {0, k, 0, 0}, free).back()[1];
        (at_end < -curvature_per_m ? low : high) = k;
    }
    const testing::RodOde tip = testing::integrate_elastica(EI, 0, w, free, {0, low, 0, 0}, free).back();
    return 1e3 * (rod.state().p_W.back() - Vector3d(edge / 2 + tip[2], 0, tip[3])).norm();
}

TEST(RodMemory, bends_under_its_weight_like_the_elastica_that_was_curved_before) {
    for (const double EI : {3e-8, 3e-7}) {
        const double coarse = curled_cantilever_error_mm(50, EI, 33.0),
                     fine = curled_cantilever_error_mm(100, EI, 33.0);
        std::printf("curled cantilever EI %g: tip error %.5f, %.5f mm\n", EI, coarse, fine);
        EXPECT_LT(fine, 0.03);
        EXPECT_NEAR(coarse / fine, 4.0, 0.8);
    }
}

TEST(RodMemory, turns_its_curl_with_the_jaws_that_hold_it) {
    RodParameters parameters = curled(33.0, 3e-7);
    parameters.gravity_W_m_s2.setZero();
    Rod rod(nearly_straight(100), parameters);
    Vector3d m = rod.memory().curl_axis_W(0);
    Boundary clamp{{{0, {0, 0, 0}}, {1, {kLength_m / 100, 0, 0}}}, {}, {{0, 0, m}}};
    come_to_rest(rod, clamp, 1e-6);
    const Vector3d before = rod.state().p_W.back();
    const Eigen::AngleAxisd quarter(M_PI / 2, Vector3d::UnitX());
    std::vector<SurfaceContact> none;
    for (int i = 1; i <= 50; ++i) {
        clamp.rolls[0].m_W = Eigen::AngleAxisd(M_PI / 2 * i / 50, Vector3d::UnitX()) * m;
        rod.step(1e-3, clamp, none);
    }
    come_to_rest(rod, clamp, 1e-6);
    EXPECT_LT(before.z(), -0.02);
    EXPECT_LT((rod.state().p_W.back() - quarter * before).norm(), 1e-5);
}

TEST(RodMemory, keeps_its_curl_through_a_cut) {
    RodParameters parameters = curled(33.0, 3e-7);
    parameters.gravity_W_m_s2.setZero();
    Rod rod(nearly_straight(100), parameters);
    Boundary none;
    come_to_rest(rod, none, 1e-6);
    for (const double t : {0.0, 0.4, 1.0}) {
        rod.cut(rod.state().has_edge(60) ? 60 : 30, t);
        come_to_rest(rod, none, 1e-6);
        const auto& p = rod.state().p_W;
        const double radius = 1.0 / 33.0, length = rod.state().s_m[20] - rod.state().s_m[0];
        EXPECT_NEAR(1e3 * (p[20] - p[0]).norm(), 2e3 * radius * std::sin(length / (2.0 * radius)), 0.01);
        EXPECT_LT((p[0] - p[20]).norm(), 0.02);
    }
}

}  // namespace
}  // namespace atropos::sim
