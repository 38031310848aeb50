#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace atropos::bench {

/// Centre line of the longest thin stroke of a mask (not 0 = stroke): thinned (Zhang and Suen 1984), its
/// longest path, averaged over five points. Also the stroke's width at each of its points, on
/// average over 15 px: its area by its length.
struct CentreLine {
    std::vector<Eigen::Vector2d> points;
    std::vector<double> width_px;
};
CentreLine centre_line(const cv::Mat1b& mask);

/// The stroke of an image whose background was made white: gray <= 250, closed 3x3.
CentreLine stroke_on_white(const cv::Mat& picture);

/// Cuts off needles: the stretch at an end where the stroke is more than 5 px wide on average over 15 px. A
/// needle that only one eye shows so wide ends in the other at the same row.
void leave_needles_out(CentreLine& left, CentreLine& right);

}  // namespace atropos::bench
