#pragma once

#include <cstdint>
#include <string_view>

#include "scenes/random_stream.hpp"
#include "scenes/stereo_rig.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::experiments {

/// What an experiment makes worse between the pictures and a tracker; all zero: nothing.
struct Degradation {
    double noise_levels = 0.0;   ///< standard deviation of white noise added to each pixel, grey levels
    double blur_px = 0.0;        ///< standard deviation of a Gaussian blur
    double contrast_loss = 0.0;  ///< 0..1: share of the contrast to the picture's mean that is lost
    double tip_error_mm = 0.0;  ///< standard deviation a coordinate of a constant offset of each measured end
    double calibration_error_deg =
        0.0;  ///< turn of the right camera about the vertical that the tracker doesn't know
    double occlusion_px =
        0.0;  ///< width of a gray bar that crosses both pictures once a second, left to right

    bool any() const;
};

/// A field by its name, null when there is none.
double* degradation_field(Degradation& degradation, std::string_view field);

/// The rig that the tracker is told.
scenes::StereoRig degraded(const scenes::StereoRig& rig, const Degradation& degradation);

/// The frame that the tracker sees. The same for the same seed and frame number.
void degrade(tracker::StereoFrame& frame, const Degradation& degradation, std::uint64_t seed);

}  // namespace atropos::experiments
