#pragma once

#include <Eigen/Core>
#include <vector>

#include "scenes/stereo_rig.hpp"
#include "tracker/image_path.hpp"

namespace atropos::tracker {

/// A path in rectified coordinates: rows of both eyes agree, and the left column is the disparity larger. In
/// px of `focal_px`, from the camera's axis, so that no rectified image is needed.
struct RectifiedPath {
    std::vector<Eigen::Vector2d> points;  ///< at equal steps of arc length in the image
    std::vector<double> arc_px;           ///< of each along the ImagePath
};

/// Turns pixels of a rig into rectified coordinates and back into space.
class RectifiedView {
  public:
    explicit RectifiedView(const scenes::StereoRig& rig);

    double focal_px() const { return focal_px_; }
    RectifiedPath path(const ImagePath& path, int eye, double step_px) const;

    /// Rectified position of an eye's pixel, and back.
    Eigen::Vector2d rectified(const Eigen::Vector2d& px, int eye) const;
    Eigen::Vector2d pixel(const Eigen::Vector2d& rectified, int eye) const;

    /// Point in C of a rectified position in the left eye and its disparity > 0.
    Eigen::Vector3d point(const Eigen::Vector2d& left, double disparity_px) const;
    /// Disparity of a point in C.
    double disparity_of(const Eigen::Vector3d& p_C) const {
        return disparity_px((rectification_.R1 * p_C).z());
    }
    double depth_m(double disparity_px) const { return focal_px_ * baseline_m_ / disparity_px; }
    double disparity_px(double depth_m) const { return focal_px_ * baseline_m_ / depth_m; }

    /// The rig whose right eye is turned about the baseline's horizontal so that its rows lie `rows_px`
    /// lower.
    scenes::StereoRig with_row_offset(double rows_px) const;

  private:
    scenes::StereoRig rig_;
    scenes::Rectification rectification_;
    double focal_px_;
    double baseline_m_;
};

struct PairingOptions {
    double nearest_m = 0.015;  ///< depths looked at
    double farthest_m = 0.6;
    double row_sigma_px = 0.7;
    double largest_row_px = 2.5;     ///< beyond, being further off costs no more
    double slope_cost_per_px = 0.6;  ///< of a change of disparity
    double skip_cost_per_px = 0.25;  ///< of an end seen by one eye alone
};

/// Which point of the right path belongs to each of the left one.
struct Pairing {
    std::vector<int> right;  ///< of each left point; -1 where only the left eye sees the thread
    int right_begin = 0;     ///< points of the right path outside of [begin, end) only the right eye sees
    int right_end = 0;
    double cost = 0.0;
    double mean_row_px = 0.0;  ///< mean |row difference| of the pairs, truncated
};

/// Monotone pairing of two ordered paths along epipolar lines, by dynamic programming: squared row difference
/// (truncated), total change of disparity, free ends at a price. `row_offset_px`: rows of the right eye lie
/// lower by it. `right_turned`: pair with the right path run backwards (`right` still indexes it forwards).
Pairing pair_paths(const RectifiedView& view, const RectifiedPath& left, const RectifiedPath& right,
                   double row_offset_px, bool right_turned, const PairingOptions& options);

}  // namespace atropos::tracker
