#pragma once

#include <Eigen/Core>
#include <vector>

#include "tracker/ridge_points.hpp"

namespace atropos::tracker {

/// Two ends of pieces that were joined to one path.
struct PathJoin {
    Eigen::Vector2d from, to;  ///< the last point before it and the first behind it, px
};

/// A line traced through an image: points in order, some 1 px apart, tangents along the order. Where the line
/// was not seen but bridged, the strength is 0.
struct ImagePath {
    std::vector<RidgePoint> points;
    std::vector<PathJoin> joins = {};  ///< that it was made by, in order

    /// Arc length from the first point to each, px.
    std::vector<double> arc_lengths_px() const;
    double strength() const;  ///< sum over the points
    void reverse();

    /// First point (end 0) or last.
    const RidgePoint& end(int end) const { return end == 0 ? points.front() : points.back(); }

    /// Whether an end (0 = first point) lies within `margin_px` of the image's border.
    bool leaves_image(int end, int width, int height, double margin_px = 4.0) const;
};

/// Where an end of a path is and where it leads.
struct PathEnd {
    Eigen::Vector2d p = Eigen::Vector2d::Zero();      ///< last point, px
    Eigen::Vector2d inner = Eigen::Vector2d::Zero();  ///< some px before it
    Eigen::Vector2d far = Eigen::Vector2d::Zero();    ///< more px before it
    Eigen::Vector2d out = Eigen::Vector2d::UnitX();   ///< unit direction outwards, bending on as it bends
};

PathEnd path_end(const ImagePath& path, bool front);

/// Angle between two directions, rad, in [0, pi].
double angle_between(const Eigen::Vector2d& a, const Eigen::Vector2d& b);

}  // namespace atropos::tracker
