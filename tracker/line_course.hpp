#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "tracker/ridge_points.hpp"

namespace atropos::tracker {

/// A place of a line that both eyes follow.
struct LineNode {
    Eigen::Vector2d left = Eigen::Vector2d::Zero();  ///< rectified, in the left eye
    double disparity_px = 0.0;
    std::array<RidgePoint, 2> eye = {};           ///< where each eye sees it, px
    std::array<double, 2> contrast = {};          ///< of the line
    std::array<double, 2> clutter = {};           ///< of what lies beside it
    std::array<bool, 2> seen = {};                ///< as a line
    std::array<double, 2> arc_px = {-1.0, -1.0};  ///< along the path it came from; negative: it was grown

    bool both() const { return seen[0] && seen[1]; }
};

/// How a line goes on behind its last node.
struct LineCourse {
    Eigen::Vector2d place = Eigen::Vector2d::Zero();       ///< smoothed, rectified, of the last node
    Eigen::Vector2d direction = Eigen::Vector2d::UnitX();  ///< unit
    Eigen::Vector2d bend_per_px = Eigen::Vector2d::Zero();
    double disparity_px = 0.0;
    double slope = 0.0;  ///< of the disparity, px a px

    /// The place `s_px` ahead.
    Eigen::Vector2d ahead(double s_px) const {
        return place + s_px * direction + 0.5 * s_px * s_px * bend_per_px;
    }
};

struct LineCourseOptions {
    double memory_px = 30.0;         ///< of the line behind it, seen, from which its way is taken
    double sharpest_turn_px = 25.0;  ///< radius below which it is unlikely to bend
};

/// Least squares over the nodes seen by both eyes: the image's curve to second order, disparity to first.
LineCourse course_of(std::span<const LineNode> line, double unseen_px, const LineCourseOptions& options = {});

/// How well a line's disparity is known at its back, px: along the epipolar line, it is a guess.
double known_disparity_px(std::span<const LineNode> line);

/// Whether most of a stretch lies nearer or farther than a thread gets on the way there from the back of a
/// line. Where that way is along the epipolar line, it does not.
bool leaps(std::span<const LineNode> line, std::span<const LineNode> stretch, double focal_px);

}  // namespace atropos::tracker
