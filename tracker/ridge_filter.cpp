#include "tracker/ridge_filter.hpp"

#include <immintrin.h>

#include <algorithm>
#include <array>
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

inline __m256 set(float value) {
    return _mm256_set1_ps(value);
}

/// exp(x) for x <= 0 to 3e-7 relative: 2^whole times a polynomial of 2^f, f in (0, 1].
inline __m256 exp_negative(__m256 x) {
    const __m256 t = _mm256_mul_ps(_mm256_max_ps(x, set(-80.0f)), set(1.44269504f));
    const __m256 whole = _mm256_sub_ps(_mm256_ceil_ps(t), set(1.0f));
    const __m256 f = _mm256_sub_ps(t, whole);
    __m256 p = set(1.8775767e-3f);
    for (const float c : {8.9893397e-3f, 5.5826318e-2f, 2.4015361e-1f, 6.9315308e-1f, 9.9999994e-1f})
        p = _mm256_add_ps(_mm256_mul_ps(p, f), set(c));
    const __m256i power =
        _mm256_slli_epi32(_mm256_add_epi32(_mm256_cvtps_epi32(whole), _mm256_set1_epi32(127)), 23);
    return _mm256_mul_ps(p, _mm256_castsi256_ps(power));
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

/// out[x] = sum over taps of from[x + i step], for x < count rounded up to whole blocks.
void convolve(const HalfKernel& kernel, const float* from, std::ptrdiff_t step, int count, float* out) {
    for (int x0 = 0; x0 < count; x0 += kBlock) {
        const float* centre = from + x0;
        __m256 sum[kBlock / 8];
        for (int i = 0; i < kBlock / 8; ++i)
            sum[i] = _mm256_mul_ps(set(kernel.tap[0]), _mm256_loadu_ps(centre + 8 * i));
        for (int t = 1; t <= kernel.radius; ++t) {
            const __m256 k = set(kernel.tap[static_cast<std::size_t>(t)]);
            for (int i = 0; i < kBlock / 8; ++i) {
                const __m256 pair = _mm256_add_ps(_mm256_loadu_ps(centre - t * step + 8 * i),
                                                  _mm256_loadu_ps(centre + t * step + 8 * i));
                sum[i] = _mm256_add_ps(sum[i], _mm256_mul_ps(k, pair));
            }
        }
        for (int i = 0; i < kBlock / 8; ++i) _mm256_storeu_ps(out + x0 + 8 * i, sum[i]);
    }
}

struct MeasureFactors {
    float curvature;  ///< sigma^2 times the sign that makes the thread's curvature positive
    float either;     ///< more than any curvature when both signs count, else 0
    float blob;       ///< -1 / (2 beta^2)
    float contrast;   ///< -1 / (2 c^2)
    float least;      ///< S^2 below which the value is surely not above the floor
};

/// Frangi's measure of eight pixels from the rows of the smoothed image above, through and below them.
inline __m256 measure(const float* above, const float* here, const float* below,
                      const MeasureFactors& factors) {
    const auto at = [](const float* p) { return _mm256_loadu_ps(p); };
    const __m256 curvature = set(factors.curvature);
    const __m256 sign = set(-0.0f);
    const __m256 twice = _mm256_add_ps(at(here), at(here));
    const __m256 xx =
        _mm256_mul_ps(curvature, _mm256_sub_ps(_mm256_add_ps(at(here + 1), at(here - 1)), twice));
    const __m256 yy = _mm256_mul_ps(curvature, _mm256_sub_ps(_mm256_add_ps(at(below), at(above)), twice));
    const __m256 cross = _mm256_sub_ps(_mm256_sub_ps(at(below + 1), at(below - 1)),
                                       _mm256_sub_ps(at(above + 1), at(above - 1)));
    const __m256 xy = _mm256_mul_ps(_mm256_mul_ps(curvature, set(0.25f)), cross);
    const __m256 mean = _mm256_mul_ps(set(0.5f), _mm256_add_ps(xx, yy));
    const __m256 right_sign = _mm256_cmp_ps(_mm256_add_ps(mean, set(factors.either)), set(0.0f), _CMP_GT_OQ);
    const __m256 xy_squared = _mm256_mul_ps(xy, xy);
    const __m256 sum_of_squares = _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(xx, xx), _mm256_mul_ps(yy, yy)),
                                                _mm256_add_ps(xy_squared, xy_squared));  // S^2
    const __m256 enough = _mm256_cmp_ps(sum_of_squares, set(factors.least), _CMP_GE_OQ);
    if (_mm256_movemask_ps(_mm256_and_ps(right_sign, enough)) == 0) return _mm256_setzero_ps();
    const __m256 half = _mm256_mul_ps(set(0.5f), _mm256_sub_ps(xx, yy));
    const __m256 spread = _mm256_sqrt_ps(_mm256_add_ps(_mm256_mul_ps(half, half), xy_squared));
    const __m256 magnitude = _mm256_andnot_ps(sign, mean);
    const __m256 large = _mm256_add_ps(magnitude, spread);  // |l2|
    const __m256 small = _mm256_sub_ps(magnitude, spread);  // |l1|, up to its sign
    const __m256 small_squared = _mm256_mul_ps(small, small);
    const __m256 large_squared = _mm256_mul_ps(large, large);
    const __m256 ratio = _mm256_div_ps(small_squared, _mm256_max_ps(large_squared, set(1e-20f)));
    const __m256 line = exp_negative(_mm256_mul_ps(set(factors.blob), ratio));
    const __m256 contrast =
        exp_negative(_mm256_mul_ps(set(factors.contrast), _mm256_add_ps(large_squared, small_squared)));
    const __m256 v = _mm256_mul_ps(line, _mm256_sub_ps(set(1.0f), contrast));
    return _mm256_and_ps(v, right_sign);
}

/// The measure of `count` pixels, kept where it is larger than before.
void measure_row(const float* above, const float* here, const float* below, int count,
                 const MeasureFactors& factors, float* ridge) {
    for (int x = 0; x < count; x += 8) {
        const __m256i inside =
            _mm256_cmpgt_epi32(_mm256_set1_epi32(count - x), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
        const __m256 v = measure(above + x, here + x, below + x, factors);
        _mm256_maskstore_ps(ridge + x, inside, _mm256_max_ps(v, _mm256_maskload_ps(ridge + x, inside)));
    }
}

}  // namespace

RidgeFilter::RidgeFilter(RidgeFilterOptions options) : options_(std::move(options)) {
    if (options_.sigmas_px.empty())
        throw std::invalid_argument("a ridge filter without scales, expected one or more");
    const double largest = *std::max_element(options_.sigmas_px.begin(), options_.sigmas_px.end());
    reach_px_ = radius_px(largest) + 1;
}

void RidgeFilter::reserve(int width, int height) {
    const std::size_t most = static_cast<std::size_t>(width + 2 * reach_px_ + kBlock) *
                             static_cast<std::size_t>(height + 2 * reach_px_);
    for (std::vector<float>* buffer : {&source_, &horizontal_, &smooth_}) buffer->reserve(most);
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
    factors.either = options_.polarity == scenes::ThreadPolarity::kEither ? 1e9f : 0.0f;
    factors.blob = static_cast<float>(-0.5 / (options_.blobness * options_.blobness));
    factors.contrast = static_cast<float>(-0.5 / (options_.contrast_levels * options_.contrast_levels));
    // v <= 1 - exp(-S^2 / 2 c^2); a little less, for the rounding of both.
    factors.least =
        static_cast<float>(0.999 * std::log1p(-std::min(options_.floor, 0.999)) / factors.contrast);
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
