#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace atropos::tracker {

/// Euclidean distance of every pixel to the nearest ridge pixel, truncated (II-E). Exact: column distances by
/// two sweeps, then the minimum over a row of (dx^2 + column distance^2), both over many pixels at a time.
class DistanceTransform {
  public:
    /// Largest truncation that the 16-bit squares hold.
    static constexpr int kMaxTruncation = 180;

    /// `mask`: nonzero on ridges, `width` x `height` pixels with `mask_stride` between rows. `squared`
    /// becomes min(d, truncation)^2 in px^2 of the pixels of `wanted`, stride `squared_stride`. Throws
    /// std::invalid_argument unless 1 <= truncation <= kMaxTruncation.
    void apply(const std::uint8_t* mask, int mask_stride, int width, int height, int truncation,
               const cv::Rect& wanted, std::uint16_t* squared, int squared_stride);

    /// Makes room for pictures of this size, so that smaller ones allocate nothing.
    void reserve(int width, int height, int truncation);

  private:
    std::vector<std::uint8_t> column_;   ///< distance along the column, truncated
    std::vector<std::uint16_t> padded_;  ///< one row of squares with `truncation` far pixels on either side
};

}  // namespace atropos::tracker
