#pragma once

#include <Eigen/Core>
#include <vector>

#include "scenes/stereo_rig.hpp"
#include "scenes/tracker_config.hpp"

namespace atropos::tracker {

/// L(r, s) (II-D3): zero first, then for each of seven directions r steps on either side: 14 r + 1
/// displacements, s along an axis and (s, s, s) along a diagonal, so that the set samples a cube of side 2 r
/// s. `axes`: columns are the three axes, `Identity` = those of C.
std::vector<Eigen::Vector3d> label_set(int r, double s_m,
                                       const Eigen::Matrix3d& axes = Eigen::Matrix3d::Identity());

/// Axes of a label set at a point: the third along its viewing ray and `depth_factor` long, the first two
/// across it and of unit length (the paper's "non-uniform label sets").
Eigen::Matrix3d ray_axes(const Eigen::Vector3d& p_C, double depth_factor);

/// Spacing s of the first step in metres: as given, or from the reach in pixels of a preset at depth z.
double label_spacing_m(const scenes::TrackerConfig& config, const scenes::StereoRig& rig, double z_m);

}  // namespace atropos::tracker
