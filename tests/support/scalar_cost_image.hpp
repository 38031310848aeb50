#pragma once

#include <opencv2/core.hpp>

namespace atropos::support {

/// The steps of II-E as their formulae say, one pixel at a time: what the fast ones are compared with, in
/// value and in time.

/// Frangi's measure at a pixel of a dark line's picture, in double; the image is continued by its last
/// pixels.
double scalar_ridge(const cv::Mat1b& image, int x, int y, double sigma_px, double beta, double c);

/// 255 where the measure exceeds `threshold`.
cv::Mat1b scalar_mask(const cv::Mat1b& image, double sigma_px, double beta, double c, double threshold);

/// Squared distance to the nearest mask pixel within the truncation, by looking at all of them, px^2.
cv::Mat1w scalar_squared_distance(const cv::Mat1b& mask, int truncation_px);

}  // namespace atropos::support
