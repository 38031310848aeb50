#include "tracker/normal_profile.hpp"

#include <algorithm>
#include <cmath>

namespace atropos::tracker {
namespace {

/// Narrows first ... last to the indices i for which a + i * d lies in [0, limit].
void clip(double a, double d, double limit, int& first, int& last) {
    if (std::abs(d) < 1e-9) {
        if (a < 0.0 || a > limit) last = first - 1;
        return;
    }
    const double low = std::min(-a / d, (limit - a) / d);
    const double high = std::max(-a / d, (limit - a) / d);
    first = std::max(first, static_cast<int>(std::ceil(std::clamp(low, -1e6, 1e6))));
    last = std::min(last, static_cast<int>(std::floor(std::clamp(high, -1e6, 1e6))));
}

}  // namespace

void NormalProfile::read(const ImageView& image, const NormalLine& line, double step_px, int half_count,
                         int taps, double tap_step_px) {
    half = std::min(half_count, kMaxHalf);
    first = -half;
    last = half;
    const Eigen::Vector2d step = step_px * line.normal;
    const auto tap_start = [&](int k) -> Eigen::Vector2d {
        return line.p_px + (k - 0.5 * (taps - 1)) * tap_step_px * line.tangent;
    };
    for (int k = 0; k < taps; ++k) {
        const Eigen::Vector2d p = tap_start(k);
        clip(p.x(), step.x(), image.width - 1.001, first, last);
        clip(p.y(), step.y(), image.height - 1.001, first, last);
    }
    for (int i = first; i <= last; ++i) (*this)[i] = 0.0f;
    for (int k = 0; k < taps; ++k) {
        const Eigen::Vector2d p = tap_start(k);
        for (int i = first; i <= last; ++i)  // a rounding error below 0 reads pixel 0
            (*this)[i] +=
                image.bilinear(std::max(0.0, p.x() + i * step.x()), std::max(0.0, p.y() + i * step.y()));
    }
    const float mean = 1.0f / static_cast<float>(taps);
    for (int i = first; i <= last; ++i) (*this)[i] *= mean;
}

}  // namespace atropos::tracker
