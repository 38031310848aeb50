#pragma once

#include <cstdint>

#include "scenes/stereo_rig.hpp"

namespace atropos::render {

/// How far a calibration is from the truth, one sigma each. Own choice, about what a checkerboard calibration
/// with 0.3 px reprojection error leaves.
struct CalibrationError {
    double focal_relative = 5e-4;  ///< both eyes alike, as their boards were
    double centre_px = 0.3;        ///< on a 640 wide image, each eye
    double k1 = 0.003;
    double rotation_rad = 2e-4;  ///< right eye against left, each axis
    double baseline_m = 15e-6;   ///< each axis

    CalibrationError operator*(double factor) const {
        return {factor * focal_relative, factor * centre_px, factor * k1, factor * rotation_rad,
                factor * baseline_m};
    }
};

/// The rig as a tracker is told it, drawn from the stream "calibration".
scenes::StereoRig told_rig(const scenes::StereoRig& truth, const CalibrationError& error, std::uint64_t seed);

}  // namespace atropos::render
