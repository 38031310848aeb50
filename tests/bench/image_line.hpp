#pragma once

#include <Eigen/Core>
#include <vector>

namespace atropos::bench {

/// A line in an image, px.
using ImageLine = std::vector<Eigen::Vector2d>;

/// Of a point from the nearest place of the line, px.
double distance_px(const ImageLine& line, const Eigen::Vector2d& p);

/// Of the points of one line from the other, px; 0 when it has none.
double mean_distance_px(const ImageLine& from, const ImageLine& to);

/// Discrete Frechet distance (Eiter and Mannila 1994) between two lines that are not empty, px.
double frechet_px(const ImageLine& a, const ImageLine& b);

/// How often a line crosses itself.
int self_crossings(const ImageLine& line);

}  // namespace atropos::bench
