#pragma once

#include <string>
#include <vector>

#include "sim/thread_options.hpp"

namespace atropos::sim {

/// What a thread's parameters mean, for `atropos info`.
struct DerivedPhysics {
    double linear_density_kg_m = 0.0;
    double mass_kg = 0.0;
    /// (EI / (lambda g))^(1/3): shorter threads keep the direction of their jaws, longer ones hang.
    double gravity_bending_length_m = 0.0;
    double edge_length_m = 0.0;
    double edge_over_diameter = 0.0;
    double strain_at_1_N = 0.0;
    double buckling_load_N = 0.0;       ///< Euler's, pinned at both ends
    double expected_cost = 0.0;         ///< CPU seconds a simulated second, carried, without a knot
    double expected_knot_cost = 0.0;    ///< the same while an overhand knot is drawn tight
    std::vector<std::string> warnings;  ///< one line each, outside the range the model was checked in
};
DerivedPhysics derived_physics(const ThreadOptions& thread, double gravity_m_s2 = 9.81);

/// Bending stiffness of a thread of that linear density whose free end sags by `sag_m` below the clamp when
/// `length_m` of it is clamped horizontally and hangs under its own weight: the bench measurement behind
/// `atropos info --fit-sag`. Solves the elastica, so large sags are right too. Throws std::invalid_argument
/// unless 0 < sag < 0.95 length.
double fit_sag_EI(double length_m, double sag_m, double linear_density_kg_m, double gravity_m_s2 = 9.81);

/// Sag of the free end of that cantilever, the inverse of `fit_sag_EI`.
double cantilever_sag_m(double length_m, double EI_N_m2, double linear_density_kg_m,
                        double gravity_m_s2 = 9.81);

}  // namespace atropos::sim
