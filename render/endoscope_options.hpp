#pragma once

#include "render/offscreen_context.hpp"

namespace atropos::render {

struct EndoscopeOptions {
    Backend backend = Backend::kAutomatic;
    int supersampling = 1;              ///< samples a pixel and axis: 1 or 2
    double psf_sigma_at_640_px = 0.55;  ///< the lens: Gaussian point spread on a 640 wide image; own choice
    bool shadows = false;               ///< of everything on everything; the layer at rest is then not cached
    bool cache_layer_at_rest = true;    ///< draw items at rest once while they and the camera keep still
    int threads = 1;                    ///< any number gives the same bytes
    double near_m = 0.005;
    double far_m = 1.0;

    /// Point spread on an image `width_px` wide, never so sharp that a thin thread aliases.
    double psf_sigma_px(int width_px) const;
};

/// `fast`: one scene sample a pixel. `quality`: 2x2 samples. The thread is drawn analytically in both.
/// Throws std::invalid_argument for other names.
EndoscopeOptions endoscope_preset(const std::string& name);

}  // namespace atropos::render
