#pragma once

#include <array>

#include "render/ribbon_strip.hpp"

namespace atropos::render {

/// Light that comes from each strip of a cross section at `p_E` towards the eye.
std::array<Eigen::Vector3f, kStrips> shade_cross_section(const ThreadRibbon& ribbon, const EyeLight& light,
                                                         const Eigen::Vector3d& p_E,
                                                         const Eigen::Vector3d& along_E, double s_m,
                                                         double px_per_m);

}  // namespace atropos::render
