#include "tracker/ridge_filter.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

namespace atropos::tracker {
namespace {

constexpr int kBlock = 32;              // pixels a block of the row and column passes
constexpr double kSupportSigmas = 3.0;  // half-width of the sampled Gaussian
constexpr double kSmallestSigma_px = 0.9;

int radius_px(double sigma_px) {
    return static_cast<int>(std::ceil(kSupportSigmas * sigma_px));
}

/// exp(x) for x <= 0 to 3e-7 relative; a polynomial of 2^f, so that the compiler can do eight at a time.
inline float exp_negative(float x) {
    const float t = std::max(x, -80.0f) * 1.44269504f;
    const int whole = static_cast<int>(t) - 1;
    const float f = t - static_cast<float>(whole);  // in (0, 1]
    float p = 1.8775767e-3f;
    p = p * f + 8.9893397e-3f;
    p = p * f + 5.5826318e-2f;
    p = p * f + 2.4015361e-1f;
    p = p * f + 6.9315308e-1f;
    p = p * f + 9.9999994e-1f;
    return p * std::bit_cast<float>((whole + 127) << 23);
}

/// Half of a symmetric Gaussian kernel that sums to one: [0] is the centre.
struct HalfKernel {
    std::array<float, 64> tap{};
    int radius = 0;

    explicit HalfKernel(double sigma_px) : radius(std::min(radius_px(sigma_px), 63)) {
        double sum = 0.0;
        for (int i = -radius; i <= radius; ++i) sum += std::exp(-0.5 * i * i / (sigma_px * sigma_px));
        for (int i = 0; i <= radius; ++i)
            tap[static_cast<std::size_t>(i)] =
                static_cast<float>(std::exp(-0.5 * i * i / (sigma_px * sigma_px)) / sum);
    }
};

/// out[x] = sum over taps of from[x + i step], for x < count (rounded up to whole blocks).
void convolve(const HalfKernel& kernel, const float* from, std::ptrdiff_t step, int count, float* out) {
    for (int x0 = 0; x0 < count; x0 += kBlock) {
        float sum[kBlock];
        for (int i = 0; i < kBlock; ++i) sum[i] = kernel.tap[0] * from[x0 + i];
        for (int t = 1; t <= kernel.radius; ++t) {
            const float k = kernel.tap[static_cast<std::size_t>(t)];
            const float* before = from + x0 - t * step;
            const float* after = from + x0 + t * step;
            for (int i = 0; i < kBlock; ++i) sum[i] += k * (before[i] + after[i]);
        }
        std::copy(sum, sum + kBlock, out + x0);
    }
}

struct MeasureFactors {
    float curvature;  ///< sigma^2 times the sign that makes the thread's curvature positive
    float either;     ///< 1 when both signs count
    float blob;       ///< -1 / (2 beta^2)
    float contrast;   ///< -1 / (2 c^2)
};

/// Frangi's measure of `count` pixels, kept where larger than before.
void measure_row(const float* above, const float* here, const float* below, int count,
                 const MeasureFactors& factors, float* ridge) {
    for (int x = 0; x < count; ++x) {
        const float xx = factors.curvature * (here[x + 1] - 2.0f * here[x] + here[x - 1]);
        const float yy = factors.curvature * (below[x] - 2.0f * here[x] + above[x]);
        const float xy =
            factors.curvature * 0.25f * (below[x + 1] - below[x - 1] - above[x + 1] + above[x - 1]);
        const float mean = 0.5f * (xx + yy);
        const float half = 0.5f * (xx - yy);
        const float spread = std::sqrt(half * half + xy * xy);
        const float large = std::abs(mean) + spread;            // |l2|
        const float small = std::abs(std::abs(mean) - spread);  // |l1|
        const float ratio = small / std::max(large, 1e-12f);
        const float strength = large * large + small * small;
        const float v =
            exp_negative(factors.blob * ratio * ratio) * (1.0f - exp_negative(factors.contrast * strength));
        const float right_sign = std::max(factors.either, mean > 0.0f ? 1.0f : 0.0f);
        ridge[x] = std::max(ridge[x], right_sign * v);
    }
}

}  // namespace

RidgeFilter::RidgeFilter(RidgeFilterOptions options) : options_(std::move(options)) {
    if (options_.sigmas_px.empty())
        throw std::invalid_argument("a ridge filter without scales, expected one or more");
    const double largest = *std::max_element(options_.sigmas_px.begin(), options_.sigmas_px.end());
    reach_px_ = radius_px(largest) + 1;
}

void RidgeFilter::apply(const float* gray, int width, int height, std::size_t stride, const cv::Rect& region,
                        std::vector<float>& ridge) {
    const std::size_t area = static_cast<std::size_t>(region.width) * static_cast<std::size_t>(region.height);
    ridge.assign(area, 0.0f);
    source_width_ = region.width + 2 * reach_px_ + kBlock;
    const int source_height = region.height + 2 * reach_px_;
    source_.resize(static_cast<std::size_t>(source_width_) * static_cast<std::size_t>(source_height));
    horizontal_.resize(source_.size());
    smooth_.resize(source_.size());
    for (int y = 0; y < source_height; ++y) {
        const int from_y = std::clamp(region.y - reach_px_ + y, 0, height - 1);
        const float* from = gray + static_cast<std::size_t>(from_y) * stride;
        float* to = source_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(source_width_);
        const int x0 = region.x - reach_px_;
        const int inside_begin = std::clamp(-x0, 0, source_width_);
        const int inside_end = std::clamp(width - x0, inside_begin, source_width_);
        std::fill(to, to + inside_begin, from[0]);
        std::copy(from + x0 + inside_begin, from + x0 + inside_end, to + inside_begin);
        std::fill(to + inside_end, to + source_width_, from[width - 1]);
    }
    for (const double sigma_px : options_.sigmas_px)
        accumulate_scale(sigma_px, region.width, region.height, ridge);
}

void RidgeFilter::accumulate_scale(double sigma_px, int region_width, int region_height,
                                   std::vector<float>& ridge) {
    const HalfKernel kernel(sigma_px);
    const std::ptrdiff_t w = source_width_;
    const int first = reach_px_ - 1;  // the second difference needs one pixel around the region
    for (int y = first - kernel.radius; y < first + region_height + 2 + kernel.radius; ++y)
        convolve(kernel, source_.data() + y * w + first, 1, region_width + 2,
                 horizontal_.data() + y * w + first);
    for (int y = first; y < first + region_height + 2; ++y)
        convolve(kernel, horizontal_.data() + y * w + first, w, region_width + 2,
                 smooth_.data() + y * w + first);

    MeasureFactors factors{};
    factors.curvature = static_cast<float>(sigma_px * sigma_px) *
                        (options_.polarity == scenes::ThreadPolarity::kBright ? -1.0f : 1.0f);
    factors.either = options_.polarity == scenes::ThreadPolarity::kEither ? 1.0f : 0.0f;
    factors.blob = static_cast<float>(-0.5 / (options_.blobness * options_.blobness));
    factors.contrast = static_cast<float>(-0.5 / (options_.contrast_levels * options_.contrast_levels));
    for (int y = 0; y < region_height; ++y) {
        const float* here = smooth_.data() + (y + reach_px_) * w + reach_px_;
        measure_row(here - w, here, here + w, region_width, factors,
                    ridge.data() + static_cast<std::ptrdiff_t>(y) * region_width);
    }
}

// A bar of width w is seen best at sigma = w / (2 sqrt 3), the deviation of its own profile.
std::vector<double> ridge_scales_px(const scenes::TrackerConfig& config, double px_per_m) {
    std::vector<double> sigmas;
    double sigma = std::max(kSmallestSigma_px, config.thread.width_m * px_per_m / std::sqrt(12.0));
    for (int i = 0; i < config.cost_image.scales; ++i, sigma *= config.cost_image.scale_step)
        sigmas.push_back(std::min(sigma, 20.0));
    return sigmas;
}

}  // namespace atropos::tracker
