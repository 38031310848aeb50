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

/// Blurs by the lens's point spread and takes the pixels: CV_32FC3, B G R. With `sigma_px` 0 only the samples
/// of a pixel are averaged.
cv::Mat through_lens(const EyeSamples& samples, double sigma_px);

/// The layers at the pixels' centres.
cv::Mat centre_depth(const EyeSamples& samples);
cv::Mat centre_labels(const EyeSamples& samples);

}  // namespace atropos::render
