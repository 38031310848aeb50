#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "tracker/ground_depth.hpp"
#include "tracker/image_path.hpp"
#include "tracker/stereo_pairing.hpp"

namespace atropos::tracker {

using StereoPaths = std::array<std::vector<ImagePath>, 2>;

/// A path of each eye that may be the same line.
struct Strand {
    std::array<std::size_t, 2> path{};          ///< index among the paths of each eye
    bool turned = false;                        ///< the right one runs the other way
    double strength = 0.0;                      ///< of the line that both eyes see, rows agreeing
    std::vector<Eigen::Vector2d> left;          ///< paired points, rectified,
    std::vector<double> disparity_px;           ///< their disparities, and
    std::array<std::vector<double>, 2> arc_px;  ///< their places along the path of each eye
};

/// The points that a pairing of two paths pairs.
Strand paired_strand(const RectifiedPath& left, const RectifiedPath& right, const Pairing& pairing);

struct StrandOptions {
    double least_length_px = 40.0;   ///< in the left image
    double least_row_overlap = 0.4;  ///< of the longer row range
    PairingOptions pairing{.row_sigma_px = 1.2, .largest_row_px = 3.0};
};

/// All pairs of paths that could be one line in space, strongest first. Rows may be off by the calibration.
std::vector<Strand> strands(const RectifiedView& view, const StereoPaths& paths,
                            const StrandOptions& options);

/// Where a strand leaps in depth as no thread does: rectified place in each eye.
struct DepthLeap {
    Eigen::Vector2d left, right;
};

/// The worst leap: there the strand runs on into another line. Smaller ones count between the ground and
/// `standing_px` before it alone: vessels lie there.
std::optional<DepthLeap> depth_leap(const RectifiedView& view, const Strand& strand,
                                    const GroundDepth& ground, double standing_px);

/// Share of a strand that lies more than `least_px` of disparity before the ground; nothing where the ground
/// is known beside less than a third of it.
std::optional<double> standing_share(const Strand& strand, const GroundDepth& ground, double least_px);

}  // namespace atropos::tracker
