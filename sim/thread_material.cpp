#include "sim/thread_material.hpp"

#include <array>
#include <numbers>
#include <stdexcept>

namespace atropos::sim {

namespace {

/// E is that of pulling. A braid bends as a bundle whose filaments slip on one another: between that of free
/// filaments (d_filament/d)^2 E I and the solid E I; `bending_share` is EI over the solid's.
struct Row {
    std::string_view name;
    double density_kg_m3, modulus_Pa, bending_share, twist_over_bend, self_friction, tissue_friction;
    std::string_view source;
    bool braided;
};

constexpr std::array<Row, 4> kTable{{
    {"silk", 1350.0, 8.7e9, 0.006, 0.74, 0.30, 0.15,
     "modulus: Naleway et al., J Biomed Mater Res B 103:735 (2015), silk 3-0; bending share: gives 1e-8 N m2 "
     "at 0.25 mm, assumed",
     true},
    {"polypropylene", 905.0, 1.5e9, 1.0, 0.72, 0.15, 0.15,
     "modulus 1-3 GPa in handbooks, 1.5 assumed; solid round section", false},
    {"polyglactin", 1400.0, 8.0e9, 0.006, 0.74, 0.20, 0.15,
     "braided and coated; modulus assumed near silk's, see Naleway et al. (2015) for the spread; bending "
     "share assumed",
     true},
    {"nylon", 1140.0, 1.8e9, 1.0, 0.72, 0.15, 0.15,
     "monofilament; modulus 1-3 GPa in handbooks, 1.8 assumed; solid round section", false},
}};

}  // namespace

ThreadMaterial thread_material(std::string_view name, double diameter_m) {
    if (!(diameter_m >= 1e-5 && diameter_m <= 2e-3))
        throw std::invalid_argument("thread diameter is " + std::to_string(1e3 * diameter_m) +
                                    " mm, expected 0.01 to 2 mm");
    for (const Row& row : kTable) {
        if (row.name != name) continue;
        const double r = 0.5 * diameter_m;
        const double area = std::numbers::pi * r * r, second_moment = 0.25 * std::numbers::pi * r * r * r * r;
        ThreadMaterial m;
        m.name = name;
        m.density_kg_m3 = row.density_kg_m3;
        m.EA_N = row.modulus_Pa * area;
        m.EI_N_m2 = row.bending_share * row.modulus_Pa * second_moment;
        m.GJ_N_m2 = row.twist_over_bend * m.EI_N_m2;
        m.self_friction = row.self_friction;
        m.tissue_friction = row.tissue_friction;
        m.source = row.source;
        m.assumed = {"self_friction", "tissue_friction", "jaw_friction", "GJ_N_m2"};
        if (row.braided) m.assumed.push_back("EI_N_m2");
        if (row.name != "silk") m.assumed.push_back("EA_N");
        return m;
    }
    std::string known;
    for (const Row& row : kTable) known += (known.empty() ? "" : ", ") + std::string(row.name);
    throw std::invalid_argument("unknown thread material '" + std::string(name) + "', expected one of " +
                                known);
}

std::vector<std::string> thread_material_names() {
    std::vector<std::string> names;
    for (const Row& row : kTable) names.emplace_back(row.name);
    return names;
}

double usp_diameter_m(std::string_view size) {
    if (size == "4-0") return 0.175e-3;
    if (size == "3-0") return 0.225e-3;
    if (size == "2-0") return 0.320e-3;
    if (size == "0") return 0.375e-3;
    throw std::invalid_argument("unknown USP size '" + std::string(size) + "', expected 4-0, 3-0, 2-0 or 0");
}

}  // namespace atropos::sim
