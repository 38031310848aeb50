#pragma once

#include <opencv2/core.hpp>
#include <span>

#include "render/lens.hpp"
#include "render/scene_program.hpp"

namespace atropos::render {

/// Lamp in one eye's frame.
struct EyeLight {
    Light light;
    Eigen::Vector3d p_EL;
    Eigen::Vector3d axis_E;
};

/// Paints the threads over `linear` (CV_32FC3) and adds to `coverage` (CV_32F, zero at first).
///
/// Each thread is the band between the two edges of its round body, blurred by the lens in closed form:
/// across the band the light of narrow strips is weighted by differences of the normal distribution, so that
/// neither the place nor the width of the thread depends on where pixels fall. Distances are taken on the
/// distorted image. Where a thread crosses itself or another the nearer strand lies on top; nearer parts of
/// the scene hide it.
void paint_ribbons(std::span<const ThreadRibbon> ribbons, const Eye& eye, const Eigen::Isometry3d& X_EW,
                   const EyeLight& light, const EyeSamples& scene, double sigma_px, cv::Mat& linear,
                   cv::Mat& coverage);

}  // namespace atropos::render
