#include "sim/derived_physics.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace atropos::sim {

namespace {

constexpr int kSteps = 500;
constexpr double kSmallestLoad = 1e-9, kLargestLoad = 1e5;  // of q; the latter is 46 gravity-bending lengths

struct Root {
    double angle, sag;
};

/// Elastica of unit length with load q = lambda g L^3 / EI, from its free end to the clamp: psi'' = q u sin
/// psi, psi the angle to the vertical, u the length below; psi(0) = `start`, psi'(0) = 0. From this end the
/// equation only grows, so that shooting stays well-conditioned for limp threads. Runge-Kutta.
Root shoot(double q, double start) {
    using State = std::array<double, 3>;  // angle, its derivative, height
    const auto f = [q](double u, const State& y) {
        return State{y[1], q * u * std::sin(y[0]), std::cos(y[0])};
    };
    const auto plus = [](const State& a, double h, const State& b) {
        return State{a[0] + h * b[0], a[1] + h * b[1], a[2] + h * b[2]};
    };
    State y{start, 0.0, 0.0};
    const double h = 1.0 / kSteps;
    for (int i = 0; i < kSteps; ++i) {
        const double u = i * h;
        const State k1 = f(u, y), k2 = f(u + h / 2, plus(y, h / 2, k1)),
                    k3 = f(u + h / 2, plus(y, h / 2, k2)), k4 = f(u + h, plus(y, h, k3));
        y = plus(plus(plus(plus(y, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
        if (y[0] > std::numbers::pi) break;  // far beyond any clamp
    }
    return {y[0], y[2]};
}

/// Sag over length: of the free end's angle that leaves the clamp horizontal.
double relative_sag(double q) {
    double low = std::log(1e-200), high = std::log(0.5 * std::numbers::pi);
    for (int i = 0; i < 60; ++i) {
        const double start = 0.5 * (low + high);
        (shoot(q, std::exp(start)).angle < 0.5 * std::numbers::pi ? low : high) = start;
    }
    return shoot(q, std::exp(low)).sag;
}

}  // namespace

double cantilever_sag_m(double length_m, double EI_N_m2, double linear_density_kg_m, double gravity_m_s2) {
    return length_m * relative_sag(linear_density_kg_m * gravity_m_s2 * std::pow(length_m, 3) / EI_N_m2);
}

double fit_sag_EI(double length_m, double sag_m, double linear_density_kg_m, double gravity_m_s2) {
    if (!(length_m > 0.0 && linear_density_kg_m > 0.0))
        throw std::invalid_argument("cantilever length and linear density must be positive");
    if (!(sag_m > 0.0 && sag_m < 0.95 * length_m))
        throw std::invalid_argument("sag is " + std::to_string(1e3 * sag_m) +
                                    " mm, expected between 0 and 0.95 of the " +
                                    std::to_string(1e3 * length_m) + " mm length");
    double low = std::log(kSmallestLoad), high = std::log(kLargestLoad);  // the sag grows with q
    for (int i = 0; i < 50; ++i) {
        const double q = 0.5 * (low + high);
        (relative_sag(std::exp(q)) < sag_m / length_m ? low : high) = q;
    }
    return linear_density_kg_m * gravity_m_s2 * std::pow(length_m, 3) / std::exp(low);
}

DerivedPhysics derived_physics(const ThreadOptions& thread, double gravity_m_s2) {
    const ThreadMaterial& m = thread.material;
    const double length = thread.length_m > 0.0 ? thread.length_m : 0.07, d = thread.diameter_m;
    DerivedPhysics p;
    p.linear_density_kg_m = m.density_kg_m3 * std::numbers::pi * d * d / 4.0;
    p.mass_kg = p.linear_density_kg_m * length;
    p.gravity_bending_length_m = std::cbrt(m.EI_N_m2 / (p.linear_density_kg_m * gravity_m_s2));
    p.edge_length_m = length / thread.edges;
    p.edge_over_diameter = p.edge_length_m / d;
    p.strain_at_1_N = 1.0 / m.EA_N;
    p.buckling_load_N = std::numbers::pi * std::numbers::pi * m.EI_N_m2 / (length * length);
    // As sim_bench measures them on one 2.1 GHz core: carried at 100 to 300 edges, a knot at 140 to 300.
    p.expected_cost = 1.3e-3 * thread.edges;
    p.expected_knot_cost = 0.4 * std::pow(thread.edges / 140.0, 2.4);
    const auto warn = [&](bool when, const std::string& text) {
        if (when) p.warnings.push_back(text);
    };
    warn(p.edge_over_diameter > 3.0,
         "edges are longer than 3 diameters: a knot would be coarse, use more edges");
    warn(p.edge_over_diameter < 1.0, "edges are shorter than 1 diameter: slow, use fewer edges");
    warn(p.expected_knot_cost > 1.0, "a knot drawn tight with " + std::to_string(thread.edges) +
                                         " edges is slower than real time: use fewer edges");
    warn(p.expected_cost > 1.0,
         std::to_string(thread.edges) + " edges are slower than real time: use fewer edges");
    warn(m.EI_N_m2 > 0.0 && p.gravity_bending_length_m < 3.0 * p.edge_length_m,
         "bends within 3 edges under its own weight: the shape is not resolved, use more edges");
    warn(m.EA_N < 1.0 || m.EA_N > 1e5, "axial stiffness outside 1 N to 100 kN was not checked");
    warn(m.EI_N_m2 > 1e-4, "bending stiffness above 1e-4 N m2 is no thread");
    warn(length < 0.01 || length > 1.0, "length outside 10 mm to 1 m was not checked");
    warn(d < 0.1e-3 || d > 0.5e-3, "diameter outside 0.1 to 0.5 mm was not checked");
    for (const std::string& field : m.assumed)
        p.warnings.push_back(field + " of " + m.name + " is assumed, not measured: sweep it");
    return p;
}

}  // namespace atropos::sim
