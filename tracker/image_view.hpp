#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>

#include "scenes/tracker_config.hpp"

namespace atropos::tracker {

/// One 8-bit channel of an image that somebody else owns; pixel centres at integers.
struct ImageView {
    const std::uint8_t* data = nullptr;
    std::ptrdiff_t row_step = 0;
    std::ptrdiff_t pixel_step = 1;
    int width = 0;
    int height = 0;

    std::uint8_t at(int u, int v) const { return data[v * row_step + u * pixel_step]; }

    /// Whether bilinear interpolation at (u, v) reads pixels of the image alone.
    bool covers(double u, double v) const { return u >= 0.0 && v >= 0.0 && u < width - 1 && v < height - 1; }

    /// Bilinear value; (u, v) must be covered.
    float bilinear(double u, double v) const {
        const int iu = static_cast<int>(u);
        const int iv = static_cast<int>(v);
        const float fu = static_cast<float>(u - iu);
        const float fv = static_cast<float>(v - iv);
        const std::uint8_t* p = data + iv * row_step + iu * pixel_step;
        const std::uint8_t* q = p + row_step;
        const float top = static_cast<float>(p[0]) + fu * static_cast<float>(p[pixel_step] - p[0]);
        const float low = static_cast<float>(q[0]) + fu * static_cast<float>(q[pixel_step] - q[0]);
        return top + fv * (low - top);
    }
};

/// The wanted channel of an 8-bit gray or BGR image; `buffer` holds it where it has to be computed.
ImageView channel_view(const cv::Mat& image, scenes::ImageChannel channel, cv::Mat& buffer);

}  // namespace atropos::tracker
