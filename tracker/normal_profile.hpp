#pragma once

#include <Eigen/Core>
#include <array>

#include "tracker/image_view.hpp"

namespace atropos::tracker {

/// A line across an image curve: through `p_px` along the unit `normal`; `tangent` is across it.
struct NormalLine {
    Eigen::Vector2d p_px = Eigen::Vector2d::Zero();
    Eigen::Vector2d normal = Eigen::Vector2d::UnitX();
    Eigen::Vector2d tangent = Eigen::Vector2d::UnitY();
};

/// Grey levels along a normal line, at offsets i * step; the mean of some parallel lines side by side, which
/// lowers the noise. Indices run from -half to half, as far as the image reaches: first ... last.
struct NormalProfile {
    static constexpr int kMaxHalf = 95;

    int half = 0;
    int first = 0;
    int last = -1;
    std::array<float, 2 * kMaxHalf + 1> level{};

    float& operator[](int i) { return level[static_cast<std::size_t>(i + half)]; }
    float operator[](int i) const { return level[static_cast<std::size_t>(i + half)]; }

    /// `half_count` is cut to kMaxHalf; `taps` parallel lines at distances of `tap_step_px`.
    void read(const ImageView& image, const NormalLine& line, double step_px, int half_count, int taps,
              double tap_step_px);
};

}  // namespace atropos::tracker
