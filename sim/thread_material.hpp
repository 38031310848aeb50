#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace atropos::sim {

/// What a thread is made of. Stiffnesses belong to one diameter; `thread_material` computes them.
struct ThreadMaterial {
    std::string name = "silk";
    double density_kg_m3 = 1350.0;
    double EA_N = 427.0;       ///< axial stiffness
    double EI_N_m2 = 1e-8;     ///< bending stiffness
    double GJ_N_m2 = 0.74e-8;  ///< twisting stiffness
    double self_friction = 0.3;
    double tissue_friction = 0.15;
    double jaw_friction = 0.5;  ///< serrated jaws; 0.2 if smooth
    /// Where each figure is from, and which are assumptions to be swept.
    std::string source;
    std::vector<std::string> assumed;  ///< names of the fields without a measured source
};

/// The material of that name at that diameter: silk | polypropylene | polyglactin | nylon.
/// Throws std::invalid_argument for a name that is not in the table or a diameter outside [0.01, 2] mm.
ThreadMaterial thread_material(std::string_view name, double diameter_m);
std::vector<std::string> thread_material_names();

/// Middle of the USP size's diameter range for synthetic (non-collagen) sutures, "4-0" to "0" (USP <861>).
double usp_diameter_m(std::string_view size);

}  // namespace atropos::sim
