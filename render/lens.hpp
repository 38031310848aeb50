#pragma once

#include <vector>

#include "render/scene_renderer.hpp"

namespace atropos::render {

/// One eye's samples of the scene, `supersampling` a pixel and axis.
struct EyeSamples {
    const SceneLayers& layers;
    int first_column;  ///< of this eye in the layers
    int supersampling;
    int width_px;
    int height_px;

    /// Metres at sample (x, y) of this eye, clamped to it; sample (s i, s j) is the centre of pixel (i, j).
    float depth_m(int x, int y) const;
};

/// The scene without threads as a camera sees it, kept from frame to frame.
struct EyeScene {
    cv::Mat linear;   ///< CV_32FC3, B G R: blurred by the lens's point spread
    cv::Mat depth_m;  ///< CV_32F at the pixels' centres
    cv::Mat labels;   ///< CV_8U, the same
};

/// Takes the pixels that samples in `box` (of the layers) count for; all others must be right already. With
/// `sigma_px` 0 only the samples of a pixel are averaged.
void update(EyeScene& scene, const EyeSamples& samples, double sigma_px, const cv::Rect& box);

}  // namespace atropos::render
