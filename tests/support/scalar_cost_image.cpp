#include "tests/support/scalar_cost_image.hpp"

#include <algorithm>
#include <cmath>

namespace atropos::support {

double scalar_ridge(const cv::Mat1b& image, int x, int y, double sigma, double beta, double c) {
    const int radius = static_cast<int>(std::ceil(3.0 * sigma));
    const auto smooth = [&](int cx, int cy) {
        double sum = 0.0;
        double weight = 0.0;
        for (int dy = -radius; dy <= radius; ++dy)
            for (int dx = -radius; dx <= radius; ++dx) {
                const double w = std::exp(-0.5 * (dx * dx + dy * dy) / (sigma * sigma));
                sum +=
                    w * image(std::clamp(cy + dy, 0, image.rows - 1), std::clamp(cx + dx, 0, image.cols - 1));
                weight += w;
            }
        return sum / weight;
    };
    const double s2 = sigma * sigma;
    const double xx = s2 * (smooth(x + 1, y) - 2 * smooth(x, y) + smooth(x - 1, y));
    const double yy = s2 * (smooth(x, y + 1) - 2 * smooth(x, y) + smooth(x, y - 1));
    const double xy =
        s2 * 0.25 *
        (smooth(x + 1, y + 1) - smooth(x - 1, y + 1) - smooth(x + 1, y - 1) + smooth(x - 1, y - 1));
    const double root = std::sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
    double l1 = 0.5 * (xx + yy) - root;
    double l2 = 0.5 * (xx + yy) + root;
    if (std::abs(l1) > std::abs(l2)) std::swap(l1, l2);
    if (l2 <= 0.0) return 0.0;
    const double R2 = l1 * l1 / (l2 * l2);
    return std::exp(-R2 / (2 * beta * beta)) * (1.0 - std::exp(-(l1 * l1 + l2 * l2) / (2 * c * c)));
}

cv::Mat1b scalar_mask(const cv::Mat1b& image, double sigma_px, double beta, double c, double threshold) {
    cv::Mat1b mask(image.size());
    for (int y = 0; y < image.rows; ++y)
        for (int x = 0; x < image.cols; ++x)
            mask(y, x) = scalar_ridge(image, x, y, sigma_px, beta, c) > threshold ? 255 : 0;
    return mask;
}

cv::Mat1w scalar_squared_distance(const cv::Mat1b& mask, int truncation_px) {
    cv::Mat1w squared(mask.size());
    for (int y = 0; y < mask.rows; ++y)
        for (int x = 0; x < mask.cols; ++x) {
            int nearest = truncation_px * truncation_px;
            for (int v = std::max(0, y - truncation_px); v <= std::min(mask.rows - 1, y + truncation_px); ++v)
                for (int u = std::max(0, x - truncation_px); u <= std::min(mask.cols - 1, x + truncation_px);
                     ++u)
                    if (mask(v, u)) nearest = std::min(nearest, (x - u) * (x - u) + (y - v) * (y - v));
            squared(y, x) = static_cast<std::uint16_t>(nearest);
        }
    return squared;
}

}  // namespace atropos::support
