#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "scenes/capsule.hpp"

namespace atropos::sim {

/// Jaws as a wedge that opens about the axis y of the grip frame G (z distal along the jaws, x the opening
/// direction); the pin lies at -z.
struct JawGeometry {
    double pin_to_grip_m = 6.5e-3;  ///< from the pin to G's origin
    double length_m = 10.5e-3;      ///< from the pin to the tip of the jaws
    double root_m = 2.0e-3;         ///< nearer to the pin than this nothing fits
    double half_width_m = 1.5e-3;   ///< of the pads, along y
    double hold_force_N = 10.0;  ///< of the closed jaws on the thread; the slip limit is 2 friction times it
};

/// Blades as a wedge that opens about the axis y of the blade frame S, z distal.
struct BladeGeometry {
    double pin_to_meeting_m = 6.5e-3;  ///< from the pin to S's origin
    double length_m = 10.5e-3;         ///< from the pin to the tip of the blades
    double root_m = 1.0e-3;
    double half_thickness_m = 0.5e-3;  ///< of both blades together, along y
};

struct InstrumentOptions {
    std::string name;                                 ///< e.g. "PSM1", as in the events
    std::vector<std::vector<scenes::Capsule>> links;  ///< capsules of each link, in the link's frame
    std::optional<JawGeometry> jaws;
    std::optional<BladeGeometry> blades;
    double friction = 0.2;  ///< thread against steel
};

}  // namespace atropos::sim
