#pragma once

#include <Eigen/Core>
#include <string_view>

#include "scenes/polyline.hpp"

namespace atropos::render {

/// How a suture looks. Colours are linear RGB.
struct ThreadLook {
    enum class Surface {
        kBraided,       ///< strands wound about each other: light and dark along the thread, soft sheen
        kMonofilament,  ///< smooth: one bright line along the thread
    };
    Eigen::Vector3f colour{0.055f, 0.030f, 0.190f};
    Surface surface = Surface::kBraided;
    float roughness = 0.38f;
    float specular_f0 = 0.05f;
    double pitch_in_diameters =
        2.6;          ///< length of one turn of the braid; own choice after photographs of 3-0 silk
    bool lit = true;  ///< false: `colour` as it is, for measuring
};

/// Looks by colour (violet, black, blue, undyed, red) and surface (braided, monofilament). Own choice after
/// the dyes of common sutures. Throws std::invalid_argument that lists the known names.
ThreadLook thread_look(std::string_view colour, std::string_view surface = "braided");

/// A round thread, drawn from the same curve that is the truth. Segments should be short against the curve's
/// bends: the polyline itself is drawn.
struct ThreadRibbon {
    scenes::Polyline curve_W;
    double radius_m = 0.00015;
    ThreadLook look;
};

}  // namespace atropos::render
