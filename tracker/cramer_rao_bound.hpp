#pragma once

#include <span>

#include "scenes/capsule.hpp"
#include "scenes/polyline.hpp"
#include "scenes/stereo_rig.hpp"

namespace atropos::tracker {

/// What the images hold, and what is assumed to be known besides: the priors of the bound.
struct BoundOptions {
    double width_m = 0.00035;
    double contrast_levels = 60.0;  ///< between thread and ground
    double noise_levels = 4.0;      ///< standard deviation of a pixel
    double blur_px = 0.6;           ///< of the optics; the pixel itself is added
    int control_points = 16;        ///< freedom of the curve
    double stretch_sigma = 0.007;   ///< local, of 80 pieces
    double length_sigma_m = 0.0002;
    double tip_sigma_m = 0.00005;  ///< of the measured ends
};

struct Bound {
    double mean_3d_m = 0.0;  ///< least mean distance of an estimate from the curve (eq. 22)
};

/// Bayesian Cramer-Rao bound of one frame: inverse of the Fisher information of both images about the curve's
/// control points, with priors on length and ends; none on motion and hardly any on bending. Per px of the
/// curve's image the offset across it is known to noise^2 / I, I = A^2 / (sqrt(pi) s) (1 - exp(-w^2 / (4
/// s^2))) for a bar of contrast A and width w under a blur s. Hidden places tell nothing.
Bound cramer_rao_bound(const scenes::Polyline& truth_C, const scenes::StereoRig& rig,
                       std::span<const scenes::Capsule> instruments_C, const BoundOptions& options);

}  // namespace atropos::tracker
