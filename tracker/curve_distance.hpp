#pragma once

#include <functional>

#include "scenes/polyline.hpp"
#include "scenes/stereo_rig.hpp"
#include "tracker/nurbs_curve.hpp"

namespace atropos::tracker {

/// Delta(C, C_gt) of eq. 22: integral over u of the distance from C(u) to the nearest point of `truth`;
/// `curve` is run through at even speed of arc length. One-sided: a curve that covers a part of the truth
/// scores 0. Adaptive Simpson quadrature to 1e-10 of the curve's length. Throws std::invalid_argument when
/// either has no points.
double curve_distance(const scenes::Polyline& curve, const scenes::Polyline& truth);

/// The same with u the parameter of a NURBS curve, as the paper writes it.
double curve_distance(const NurbsCurve& curve, const scenes::Polyline& truth);

/// Mean of both one-sided distances: 0 only when the curves coincide.
double symmetric_curve_distance(const scenes::Polyline& first, const scenes::Polyline& second);

/// Largest distance between points of equal share of arc length, at `count` points: shows sliding.
struct ArcLengthDistance {
    double mean_m;
    double max_m;
    double middle_m;  ///< at half the length
};
ArcLengthDistance arc_length_distance(const scenes::Polyline& curve, const scenes::Polyline& truth,
                                      int count = 101);

/// The curve as an eye sees it, pixels with z = 0: distances between such curves are those of eq. 21.
scenes::Polyline image_of(const scenes::Polyline& curve_C, const scenes::StereoRig& rig, int eye);

/// Eq. 21: mean over both images of the one-sided distance, px.
double image_distance_px(const scenes::Polyline& curve_C, const scenes::Polyline& truth_C,
                         const scenes::StereoRig& rig);

/// Its symmetric form.
double symmetric_image_distance_px(const scenes::Polyline& curve_C, const scenes::Polyline& truth_C,
                                   const scenes::StereoRig& rig);

}  // namespace atropos::tracker
