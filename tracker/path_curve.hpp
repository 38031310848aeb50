#pragma once

#include <array>
#include <optional>
#include <vector>

#include "tracker/curve_refinement.hpp"
#include "tracker/image_path.hpp"
#include "tracker/paired_points.hpp"
#include "tracker/stereo_pairing.hpp"

namespace atropos::tracker {

struct PathCurveOptions {
    int control_points = 16;
    double line_sigma_px = 0.15;
    double row_offset_px = 0.0;        ///< of the right eye, to begin with; estimated
    double row_offset_sigma_px = 1.0;  ///< about 0, before an image is seen
};

/// A curve fitted to a path in each eye.
struct PathCurve {
    Eigen::Matrix3Xd Q;  ///< cubic, control points in C, m
    double length_m = 0.0;
    double cost = 0.0;
    double row_offset_px = 0.0;
    double residual_px = 0.0;  ///< rms over both eyes
    double seen_share = 0.0;   ///< of the samples, in both eyes
    std::vector<scenes::ThreadSample> samples;
};

/// Fits the curve through `points` and refines it in both images: line residuals to the paths, even speed,
/// bending of the path's own scale; the row offset of least cost. Each sample knows its place along the
/// paths, so that strands that cross are never mixed up.
PathCurve fit_to_paths(const RectifiedView& view, const std::array<ImagePath, 2>& paths,
                       const std::vector<PairedPoint>& points, const PathCurveOptions& options);

}  // namespace atropos::tracker
