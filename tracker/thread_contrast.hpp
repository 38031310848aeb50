#pragma once

#include <array>
#include <optional>

#include "scenes/polyline.hpp"
#include "scenes/stereo_rig.hpp"
#include "tracker/image_view.hpp"
#include "tracker/valley_filter.hpp"

namespace atropos::tracker {

/// How a thread stands out in a pair of images: medians over the places where it does.
struct ThreadContrast {
    double contrast_levels = 0.0;  ///< between thread and ground, before blur
    double noise_levels =
        0.0;  ///< standard deviation of a pixel: what a bar on a slope leaves over, texture too
};

/// Measured along the true curve in both images; nothing when the thread is seen nowhere.
std::optional<ThreadContrast> thread_contrast(const std::array<ImageView, 2>& images,
                                              const scenes::Polyline& truth_C, const scenes::StereoRig& rig,
                                              double width_m, const ValleyFilterOptions& options);

}  // namespace atropos::tracker
