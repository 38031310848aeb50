#include "render/endoscope_options.hpp"

#include <algorithm>
#include <stdexcept>

namespace atropos::render {

double EndoscopeOptions::psf_sigma_px(int width_px) const {
    constexpr double kSharpest_px = 0.5;  // below it the centroid of a thin line ripples with its place
    if (psf_sigma_at_640_px <= 0.0) return 0.0;
    return std::max(kSharpest_px, psf_sigma_at_640_px * width_px / 640.0);
}

EndoscopeOptions endoscope_preset(const std::string& name) {
    EndoscopeOptions options;
    if (name == "quality") {
        options.supersampling = 2;
    } else if (name != "fast") {
        throw std::invalid_argument("no render preset '" + name + "', expected fast or quality");
    }
    return options;
}

}  // namespace atropos::render
