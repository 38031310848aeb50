#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace atropos::scenes {

/// Points joined by straight segments, in metres, in a frame the owner names.
struct Polyline {
    std::vector<Eigen::Vector3d> points;

    /// Sum of the segment lengths.
    double length_m() const;

    /// Arc length from the first point to each point; same size as `points`.
    std::vector<double> arc_lengths_m() const;

    /// Point at arc length `s_m`, clamped to [0, length]. Throws std::invalid_argument when there are no
    /// points.
    Eigen::Vector3d point_at(double s_m) const;

    /// `count` >= 2 points at equal steps of arc length, ends included.
    Polyline resampled(int count) const;

    /// Nearest point of the polyline to `p` and the arc length where it lies.
    struct Nearest {
        Eigen::Vector3d point;
        double s_m;
        double distance_m;
    };
    Nearest nearest(const Eigen::Vector3d& p) const;
};

}  // namespace atropos::scenes
