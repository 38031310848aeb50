#include <gtest/gtest.h>

#include <cmath>

#include "sim/hanging_curve.hpp"
#include "tests/sim/elastica.hpp"
#include "tests/sim/rod_support.hpp"

namespace atropos::sim {
namespace {

using Eigen::Vector3d;
using testing::come_to_rest;
using testing::sampled;
using testing::with_length;

/// Largest distance of nodes to the catenary of the same ends and length, at equal arc length.
double catenary_error_mm(int edges) {
    const double length = 0.07, span = 0.05;
    RodParameters parameters;
    parameters.EI_N_m2 = 0.0;
    parameters.GJ_N_m2 = 0.0;
    Rod rod(with_length(sampled(edges, [&](double u) { return Vector3d(span * u, 0, -0.08 * u * (1 - u)); }),
                        length),
            parameters);
    Boundary ends{{{0, {0, 0, 0}}, {edges, {span, 0, 0}}}, {}};
    come_to_rest(rod, ends);
    double low = 1e-4, high = 1.0;  // 2 a sinh(S / 2a) = L
    for (int i = 0; i < 200; ++i) {
        const double a = 0.5 * (low + high);
        (2 * a * std::sinh(span / (2 * a)) > length ? low : high) = a;
    }
    const double a = low;
    double worst = 0.0;
    for (int i = 0; i <= edges; ++i) {
        const double s = length * i / edges - 0.5 * length;
        const double x = a * std::asinh(s / a);
        const Vector3d p(0.5 * span + x, 0, a * std::cosh(x / a) - a * std::cosh(0.5 * span / a));
        worst = std::max(worst, (rod.state().p_W[static_cast<size_t>(i)] - p).norm());
    }
    return 1e3 * worst;
}

TEST(Rod, hangs_as_a_catenary_to_second_order) {
    const double coarse = catenary_error_mm(50), middle = catenary_error_mm(100),
                 fine = catenary_error_mm(200);
    RecordProperty("error_mm_at_100_edges", std::to_string(middle));
    std::printf("catenary error mm: %.5f %.5f %.5f\n", coarse, middle, fine);
    EXPECT_LT(middle, 0.01);
    EXPECT_NEAR(coarse / middle, 4.0, 0.4);
    EXPECT_NEAR(middle / fine, 4.0, 0.4);
}

/// Tip error of a rod clamped horizontally under its own weight against the elastica clamped in the middle of
/// the first edge, which is where two fixed nodes act.
double cantilever_error_mm(int edges, double EI) {
    const double length = 0.07, edge = length / edges;
    RodParameters parameters;
    parameters.EI_N_m2 = EI;
    Rod rod(sampled(edges, [&](double u) { return Vector3d(length * u, 0, 0); }), parameters);
    Boundary clamp{{{0, {0, 0, 0}}, {1, {edge, 0, 0}}}, {}};
    come_to_rest(rod, clamp);
    const double w = parameters.linear_density_kg_m * 9.81, free = length - edge / 2;
    double low = -w * free * free / EI,
           high = 0.0;  // curvature at the clamp, of the wrong sign at the tip beyond
    for (int i = 0; i < 100; ++i) {
        const double k = 0.5 * (low + high);
        (testing::integrate_elastica(EI, 0, w, free, {0, k, 0, 0}, free).back()[1] < 0.0 ? low : high) = k;
    }
    const testing::RodOde tip = testing::integrate_elastica(EI, 0, w, free, {0, low, 0, 0}, free).back();
    return 1e3 * (rod.state().p_W.back() - Vector3d(edge / 2 + tip[2], 0, tip[3])).norm();
}

TEST(Rod, bends_under_its_weight_like_the_elastica) {
    for (const double EI : {1e-8, 3e-7}) {
        const double coarse = cantilever_error_mm(50, EI), middle = cantilever_error_mm(100, EI);
        std::printf("cantilever EI %g tip error mm: %.5f %.5f\n", EI, coarse, middle);
        EXPECT_LT(middle, 0.03);
        EXPECT_NEAR(coarse / middle, 4.0, 0.8);
    }
}

/// Largest node error against the elastica with gravity between two clamps that point `angle` below the
/// horizontal.
double held_error_mm(double angle, double EI) {
    const int edges = 100;
    const double length = 0.07, edge = length / edges, span = 0.05, w_g = 9.81;
    RodParameters parameters;
    parameters.EI_N_m2 = EI;
    const Vector3d d0(std::cos(angle), 0, -std::sin(angle)), d1(std::cos(angle), 0, std::sin(angle));
    const auto curve =
        hanging_curve({-0.5 * edge * d0, d0}, {Vector3d(span, 0, 0) + 0.5 * edge * d1, d1}, length);
    Rod rod(with_length(state_along(curve.resampled(edges + 1).points), length), parameters);
    const Vector3d end(span, 0, 0);
    Boundary clamps{{{0, -0.5 * edge * d0},
                     {1, 0.5 * edge * d0},
                     {edges - 1, end - 0.5 * edge * d1},
                     {edges, end + 0.5 * edge * d1}},
                    {}};
    come_to_rest(rod, clamps);

    const double w = parameters.linear_density_kg_m * w_g, half = 0.5 * (length - edge);
    // Half of it by symmetry: th = 0 and x = span / 2 at the middle; unknown curvature at the clamp and H.
    const auto residual = [&](const Eigen::Vector2d& u) {
        const testing::RodOde y =
            testing::integrate_elastica(EI, u[1], w, half, {-angle, u[0], 0, 0}, half).back();
        return Eigen::Vector2d(y[0], (y[2] - 0.5 * span) / half);
    };
    const auto& p = rod.state().p_W;
    const auto slope = [&](size_t i) { return std::atan2((p[i + 1] - p[i]).z(), (p[i + 1] - p[i]).x()); };
    // The rod's own curvature and thrust only start Newton's method on the same branch.
    Eigen::Vector2d u((slope(1) - slope(0)) / edge, 0.0);
    u[1] = rod.pull_on_node_N(0).x() + rod.pull_on_node_N(1).x();
    for (int i = 0; i < 30; ++i) {
        const Eigen::Vector2d r = residual(u);
        const double h0 = 1e-6 * (1.0 + std::abs(u[0])), h1 = 1e-6 * EI / (half * half);
        Eigen::Matrix2d J;
        J.col(0) = (residual(u + Eigen::Vector2d(h0, 0)) - r) / h0;
        J.col(1) = (residual(u + Eigen::Vector2d(0, h1)) - r) / h1;
        u -= J.inverse() * r;
    }
    EXPECT_LT(residual(u).norm(), 1e-8);
    const auto reference = testing::integrate_elastica(EI, u[1], w, half, {-angle, u[0], 0, 0}, half);
    double worst = 0.0;
    for (int i = 1; i <= edges / 2; ++i) {
        const double s = (i - 0.5) * edge / half * 4000;
        const auto k = std::min(static_cast<size_t>(s), size_t{3999});
        const double f = s - static_cast<double>(k);
        const Vector3d q((1 - f) * reference[k][2] + f * reference[k + 1][2], 0,
                         (1 - f) * reference[k][3] + f * reference[k + 1][3]);
        worst = std::max(worst, (p[static_cast<size_t>(i)] - q).norm());
    }
    return 1e3 * worst;
}

TEST(Rod, hangs_between_two_jaws_like_the_elastica_with_gravity) {
    for (const double EI : {1e-8, 3e-7})
        for (const double degrees : {0.0, 30.0, 60.0}) {
            const double error = held_error_mm(degrees * M_PI / 180, EI);
            std::printf("held at %g degrees, EI %g: %.5f mm\n", degrees, EI, error);
            EXPECT_LT(error, 0.1);
        }
}

TEST(Rod, stretches_by_force_over_EA) {
    RodParameters parameters;
    const double length = 0.07;
    parameters.gravity_W_m_s2 = {0, 0, -1.0 / (parameters.linear_density_kg_m * length)};  // weighs 1 N
    Rod rod(sampled(100, [&](double u) { return Vector3d(0, 0, -length * u); }), parameters);
    Boundary top{{{0, {0, 0, 0}}}, {}};
    come_to_rest(rod, top, 1e-6);
    const double strain = -rod.state().p_W.back().z() / length - 1.0;
    std::printf("1 N of own weight: strain %.8f, theory %.8f\n", strain, 0.5 / 427.0);
    EXPECT_NEAR(strain, 0.5 / 427.0, 1e-6);
    EXPECT_NEAR(rod.tension_N(0), 1.0, 0.011);  // of the middle of the first edge: 0.995
    EXPECT_NEAR(rod.pull_on_node_N(0).z(), -1.0, 1e-5);
}

TEST(Rod, stays_finite_and_comes_to_rest_when_pulled_one_percent_too_long) {
    for (const double EI : {0.0, 1e-8}) {
        RodParameters parameters;
        parameters.EI_N_m2 = EI;
        const double length = 0.07;
        const auto curve = hanging_curve({Vector3d::Zero(), {1, 0, 0}}, {{0.06, 0, 0}, {1, 0, 0}}, length);
        Rod rod(with_length(state_along(curve.resampled(101).points), length), parameters);
        Boundary ends{{{0, {0, 0, 0}}, {100, {0.06, 0, 0}}}, {}};
        come_to_rest(rod, ends);
        std::vector<SurfaceContact> none;
        for (int i = 0; i < 607; ++i) {
            double& x = ends.nodes[1].p_W.x();
            x = std::min(x + 1e-4, 1.01 * length);
            rod.step(1e-3, ends, none);
        }
        double fastest = 0.0, worst = 0.0;
        for (const auto& v : rod.state().v_W) fastest = std::max(fastest, v.norm());
        for (int i = 0; i < 100; ++i)
            worst = std::max(worst, std::abs(rod.tension_N(i) / parameters.EA_N - 0.01));
        std::printf("over-pull EI %g: strain error %.2e, speed %.2e m/s\n", EI, worst, fastest);
        EXPECT_LT(worst, 1e-4);
        EXPECT_LT(fastest, 1e-3);
        EXPECT_NEAR(rod.pull_on_node_N(100).x(), -0.01 * parameters.EA_N, 0.043);
    }
}

/// Thrust of an elastica shortened by `shortening` over Euler's load: (2K/pi)^2 with 2 - 2E/K = shortening.
double thrust_over_euler(double shortening) {
    double low = 0.0, high = 0.9;
    for (int i = 0; i < 100; ++i) {
        const double k = 0.5 * (low + high);
        (2.0 - 2.0 * std::comp_ellint_2(k) / std::comp_ellint_1(k) < shortening ? low : high) = k;
    }
    const double K = std::comp_ellint_1(low);
    return 4.0 * K * K / (M_PI * M_PI);
}

double buckling_thrust_N(bool clamped, double EI) {
    RodParameters parameters;
    parameters.EI_N_m2 = EI;
    parameters.gravity_W_m_s2.setZero();
    const int edges = 100;
    const double length = 0.07, edge = length / edges;
    const double free = clamped ? length - edge : length, shortened = 0.01 * free;
    Rod rod(with_length(sampled(edges,
                                [&](double u) {
                                    return Vector3d((length - shortened) * u, 1e-3 * std::sin(M_PI * u), 0);
                                }),
                        length),
            parameters);
    Boundary ends;
    if (clamped)
        ends.nodes = {{0, {0, 0, 0}},
                      {1, {edge, 0, 0}},
                      {edges - 1, {length - shortened - edge, 0, 0}},
                      {edges, {length - shortened, 0, 0}}};
    else
        ends.nodes = {{0, {0, 0, 0}}, {edges, {length - shortened, 0, 0}}};
    come_to_rest(rod, ends, 1e-8);
    double thrust = 0.0;
    for (const PrescribedNode& n : ends.nodes)
        if (n.node >= edges - 1) thrust += rod.pull_on_node_N(n.node).x();
    const double euler = (clamped ? 4.0 : 1.0) * M_PI * M_PI * EI / (free * free);
    return thrust / euler;
}

TEST(Rod, buckles_at_the_load_of_euler) {
    const double expected = thrust_over_euler(0.01);
    const double pinned = buckling_thrust_N(false, 1e-8), clamped = buckling_thrust_N(true, 1e-8);
    std::printf("thrust over Euler's: theory %.5f, pinned %.5f, clamped %.5f\n", expected, pinned, clamped);
    EXPECT_NEAR(pinned / expected, 1.0, 0.01);
    EXPECT_NEAR(clamped / expected, 1.0, 0.01);
}

/// Out-of-plane size of a clamped-together ring with that share of Michell's critical twist, after 4 s.
double ring_buckling_m(double share) {
    RodParameters parameters;
    parameters.gravity_W_m_s2.setZero();
    parameters.drag_N_s_m2 = 1e-3;
    parameters.GJ_N_m2 = parameters.EI_N_m2;
    parameters.self_contact = false;
    const int n = 100;
    const double radius = 0.01, step = 2 * M_PI / n;
    ThreadState state;
    std::vector<Vector3d> points;
    for (int i = 0; i <= n + 1; ++i) {
        const double wave = i < 2 || i >= n ? 0.0 : 1e-5 * (std::cos(2 * i * step) + std::sin(2 * i * step));
        points.push_back({radius * std::cos(i * step), radius * std::sin(i * step), wave});
    }
    Rod rod(with_length(state_along(points), (n + 1) * 2 * radius * std::sin(step / 2)), parameters);
    Boundary ends;
    for (const int i : {0, 1, n, n + 1}) ends.nodes.push_back({i, points[static_cast<size_t>(i)]});
    const double twist = share * 2 * M_PI * std::sqrt(3.0) * parameters.EI_N_m2 / parameters.GJ_N_m2;
    const Vector3d t = (points[1] - points[0]).normalized(), m = Vector3d::UnitZ();
    ends.twists.push_back({0, n, m, Eigen::AngleAxisd(twist, t) * m, twist});
    testing::run(rod, ends, 4.0, 2e-3);
    double out = 0.0;
    for (const auto& p : rod.state().p_W) out = std::max(out, std::abs(p.z()));
    return out;
}

TEST(Rod, keeps_a_twisted_ring_flat_up_to_the_twist_of_michell) {
    const double below = ring_buckling_m(0.95), above = ring_buckling_m(1.05);
    std::printf("ring out of plane: %.2e m at 0.95, %.2e m at 1.05 of Michell's twist\n", below, above);
    EXPECT_LT(below, 1e-5);
    EXPECT_GT(above, 1e-4);
}

/// Off-axis size of a string under constant tension and that share of Greenhill's torque, started 1
/// micrometre off its axis, after 0.1 s; its far end is moved so that the tension stays. In steps of 0.1 ms,
/// because backward Euler holds down what grows faster than once a step (here 3400 /s).
double twisted_string_m(double share) {
    RodParameters parameters;
    parameters.gravity_W_m_s2.setZero();
    parameters.GJ_N_m2 = parameters.EI_N_m2;
    parameters.self_contact = false;
    parameters.EA_N = 5.0;  // gives way enough that its end can be moved as a coil takes up length
    const int edges = 200;
    const double length = 0.07, EI = parameters.EI_N_m2, tension = 4000 * EI / (length * length);
    const double stretched = length * (1 + tension / parameters.EA_N), edge = stretched / edges;
    Rod rod(with_length(sampled(edges,
                                [&](double u) {
                                    return Vector3d(stretched * u, 0,
                                                    1e-6 * std::sin(11 * M_PI * u) * std::sin(M_PI * u));
                                }),
                        length),
            parameters);
    Boundary ends{{{0, {0, 0, 0}},
                   {1, {edge, 0, 0}},
                   {edges - 1, {stretched - edge, 0, 0}},
                   {edges, {stretched, 0, 0}}},
                  {}};
    const double torque = share * 2 * std::sqrt(EI * tension);
    const double twist = torque * (length - length / edges) / parameters.GJ_N_m2;
    const Vector3d m = Vector3d::UnitZ();
    ends.twists.push_back({0, edges - 1, m, Eigen::AngleAxisd(twist, Vector3d::UnitX()) * m, twist});
    std::vector<SurfaceContact> none;
    double out = 0.0;
    for (int tick = 0; tick < 1000 && out < 1e-4; ++tick) {
        rod.step(1e-4, ends, none);
        const double pull = -rod.pull_on_node_N(edges - 1).x() - rod.pull_on_node_N(edges).x();
        for (int k = 2; k < 4; ++k)
            ends.nodes[static_cast<size_t>(k)].p_W.x() += 0.2 * (tension - pull) * length / parameters.EA_N;
        out = 0.0;
        for (const auto& p : rod.state().p_W) out = std::max(out, std::hypot(p.y(), p.z()));
    }
    return out;
}

// Below the torque the disturbance dies; above it there is no coil in which the string could rest, because
// neither the load nor the torque gives way before the coil is as wide as the thread (torque falls by 5 %
// at half a millimetre): it grows a hundredfold, to 0.1 mm. Clamped ends raise the torque of this string by
// less than 1 % (4 pi^2 / 4000 of its square), edges by less than 1 % ((k l)^2 / 12 at k l = 0.3).
TEST(Rod, coils_under_tension_at_the_torque_of_greenhill) {
    const double below = twisted_string_m(0.95), above = twisted_string_m(1.05);
    std::printf("twisted string off its axis: %.2e m at 0.95, %.2e m at 1.05 of Greenhill's torque\n", below,
                above);
    EXPECT_LT(below, 1e-6);
    EXPECT_GT(above, 1e-4);
}

TEST(Rod, has_a_twist_gradient_that_agrees_with_differences) {
    RodParameters parameters;
    Rod rod(sampled(20,
                    [](double u) {
                        return Vector3d(0.01 * std::cos(5 * u), 0.01 * std::sin(5 * u), 0.01 * u * u);
                    }),
            parameters);
    const ThreadState& state = rod.state();
    const auto t = [&](size_t i) { return (state.p_W[i + 1] - state.p_W[i]).normalized(); };
    const TwistSpan span{2, 15, t(2).cross(Vector3d::UnitX()).normalized(),
                         t(15).cross(Vector3d::UnitY()).normalized(), 0.0};
    const std::vector<Vector3d> gradient = rod.twist_gradient(span, state.p_W);
    for (size_t i = 4; i < 15; ++i)
        for (int k = 0; k < 3; ++k) {
            std::vector<Vector3d> x = state.p_W;
            x[i][k] += 1e-8;
            const double plus = rod.twist_at(span, x);
            x[i][k] -= 2e-8;
            EXPECT_NEAR(gradient[i][k], (plus - rod.twist_at(span, x)) / 2e-8,
                        1e-5 * gradient[i].norm() + 1e-6);
        }
}

}  // namespace
}  // namespace atropos::sim
