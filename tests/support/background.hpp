#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <utility>

#include "scenes/stereo_rig.hpp"

namespace atropos::support {

struct BackgroundOptions {
    std::uint64_t seed = 1;
    double depth_m = 0.120;  ///< of the wall behind the thread, on the axis
    double slope_x = 0.15;   ///< the wall leans: depth gained per m to the right
    double slope_y = -0.2;
    bool clutter = true;       ///< texture, folds, vessels, specular spots; without: evenly gray
    int vessels = 7;           ///< dark lines much like the thread
    double feature_m = 0.070;  ///< length of what is looked at: vessels and folds are drawn in its scale
    double vessel_width_m = 0.00035;
    double vessel_contrast = 40.0;  ///< grey levels
    double mean_level = 150.0;
};

/// Both eyes' view of a leaning, cluttered wall: float grey levels without noise, as large as the images of
/// the rig. Everything is painted on the wall, so that both eyes agree, but for specular spots, which don't.
std::pair<cv::Mat1f, cv::Mat1f> paint_background(const scenes::StereoRig& rig,
                                                 const BackgroundOptions& options);

}  // namespace atropos::support
