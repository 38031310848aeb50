#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "tracker/stereo_pairing.hpp"

namespace atropos::tracker {

/// A point of the thread and where it lies along the path of each eye, px; negative = not seen by that eye.
struct PairedPoint {
    Eigen::Vector3d p_C;
    std::array<double, 2> arc_px{-1.0, -1.0};
};

/// How far an end that one eye alone sees may go on, px: [eye][end in the order of the left path].
using TailLimits = std::array<std::array<double, 2>, 2>;

/// The points that a pairing gives, in the order of the left path, the ends that one eye alone sees included:
/// there the disparity goes on as it last changed. Disparity is smoothed along the thread by what each pair
/// tells of it: nothing where the thread runs along the epipolar line.
std::vector<PairedPoint> paired_points(const RectifiedView& view, const RectifiedPath& left,
                                       const RectifiedPath& right, const Pairing& pairing, bool right_turned,
                                       double row_offset_px, const TailLimits& limits);

}  // namespace atropos::tracker
