#pragma once

#include <array>
#include <vector>

#include "render/ribbon_painter.hpp"

namespace atropos::render {

/// How many strips of equal radiance a thread is cut into across its width.
inline constexpr int kStrips = 8;

/// A cross section of a thread as one eye sees it.
struct RibbonVertex {
    Eigen::Vector2d pixel;
    Eigen::Vector2d along;  ///< unit direction of the thread on the image
    double half_width_px;   ///< from the axis to the edge of the round body
    double arc_px;          ///< length on the image from the thread's start
    double depth_m;
    std::array<Eigen::Vector3f, kStrips>
        radiance;  ///< R G B from one edge to the other (along turned by +90 degrees)
};

/// The parts of a thread in front of the eye and near the image, each with vertices less than a pixel apart.
std::vector<std::vector<RibbonVertex>> ribbon_strips(const ThreadRibbon& ribbon, const Eye& eye,
                                                     const Eigen::Isometry3d& X_EW, const EyeLight& light);

}  // namespace atropos::render
