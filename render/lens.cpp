#include "render/lens.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#ifdef __F16C__
#include <immintrin.h>
#endif

namespace atropos::render {
namespace {

// Four halves (one pixel) to floats.
inline void to_floats(const std::uint16_t* half, float* out) {
#ifdef __F16C__
    _mm_storeu_ps(out, _mm_cvtph_ps(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(half))));
#else
    for (int i = 0; i < 4; ++i) {  // exact also for subnormals: scale the exponent in float
        const std::uint32_t magnitude = static_cast<std::uint32_t>(half[i] & 0x7fffu) << 13;
        const float value = std::bit_cast<float>(magnitude) * 0x1p112f;
        out[i] = half[i] & 0x8000u ? -value : value;
    }
#endif
}

// Weights of samples -n .. n for a Gaussian in samples; the tent [1 2 1] / 4 averages two samples a pixel
// evenly.
std::vector<float> kernel(double sigma_px, int supersampling) {
    if (sigma_px <= 0.0)
        return supersampling == 1 ? std::vector<float>{1.0f} : std::vector<float>{0.25f, 0.5f, 0.25f};
    const double sigma = sigma_px * supersampling;
    const int n = std::max(1, static_cast<int>(std::ceil(2.8 * sigma)));
    std::vector<float> weights(2 * static_cast<std::size_t>(n) + 1);
    double sum = 0.0;
    for (int i = -n; i <= n; ++i) sum += std::exp(-0.5 * i * i / (sigma * sigma));
    for (int i = -n; i <= n; ++i) {
        weights[static_cast<std::size_t>(i + n)] =
            static_cast<float>(std::exp(-0.5 * i * i / (sigma * sigma)) / sum);
    }
    return weights;
}

// out[x] += weight * in[step * x]: the one loop that all time goes into.
template <int kStep>
void accumulate(float weight, const float* in, float* out, int count) {
    for (int x = 0; x < count; ++x) out[x] += weight * in[kStep * x];
}

// One row of samples, blurred along the row, at the columns of `box`'s pixels: red, green and blue one after
// another.
void blur_row(const EyeSamples& s, int y, const cv::Rect& box, const std::vector<float>& weights,
              std::vector<float>& padded, float* out) {
    const int taps = static_cast<int>(weights.size()), n = taps / 2, columns = s.width_px * s.supersampling;
    const int first = box.x * s.supersampling - n, length = (box.width - 1) * s.supersampling + 1 + 2 * n;
    const std::uint16_t* row = s.layers.half_rgba.data() +
                               4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(s.layers.width) +
                                    static_cast<std::size_t>(s.first_column));
    padded.resize(3 * static_cast<std::size_t>(length));
    float rgba[4];
    for (int x = 0; x < length; ++x) {
        to_floats(row + 4 * std::clamp(first + x, 0, columns - 1), rgba);
        for (int c = 0; c < 3; ++c) padded[static_cast<std::size_t>(c * length + x)] = rgba[c];
    }
    std::fill(out, out + 3 * box.width, 0.0f);
    for (int c = 0; c < 3; ++c) {
        for (int k = 0; k < taps; ++k) {
            const auto add = s.supersampling == 1 ? accumulate<1> : accumulate<2>;
            add(weights[static_cast<std::size_t>(k)], padded.data() + c * length + k, out + c * box.width,
                box.width);
        }
    }
}

void blur(const EyeSamples& s, const std::vector<float>& weights, const cv::Rect& box, cv::Mat& image) {
    const int n = static_cast<int>(weights.size() / 2), rows = s.height_px * s.supersampling;
    const std::size_t row_size = 3 * static_cast<std::size_t>(box.width);
    // Rows blurred along themselves, kept in a ring as tall as the kernel.
    const std::size_t ring = weights.size();
    std::vector<float> blurred(row_size * ring), padded, sum(row_size);
    int next = std::max(0, box.y * s.supersampling - n);
    for (int y = box.y; y < box.y + box.height; ++y) {
        for (; next <= std::min(y * s.supersampling + n, rows - 1); ++next) {
            blur_row(s, next, box, weights, padded,
                     blurred.data() + row_size * (static_cast<std::size_t>(next) % ring));
        }
        std::fill(sum.begin(), sum.end(), 0.0f);
        for (int k = -n; k <= n; ++k) {
            const auto row = static_cast<std::size_t>(std::clamp(y * s.supersampling + k, 0, rows - 1));
            const float* in = blurred.data() + row_size * (row % ring);
            const float w = weights[static_cast<std::size_t>(k + n)];
            float* total = sum.data();
            for (std::size_t i = 0; i < row_size; ++i) total[i] += w * in[i];
        }
        float* out = image.ptr<float>(y) + 3 * box.x;
        const float *red = sum.data(), *green = red + box.width, *blue = green + box.width;
        for (int x = 0; x < box.width; ++x, out += 3) {
            out[0] = blue[x];
            out[1] = green[x];
            out[2] = red[x];
        }
    }
}

void take_centres(const EyeSamples& s, const cv::Rect& box, EyeScene& scene) {
    const int step = s.supersampling;
    for (int y = box.y; y < box.y + box.height; ++y) {
        const std::size_t row =
            static_cast<std::size_t>(y * step) * static_cast<std::size_t>(s.layers.width) +
            static_cast<std::size_t>(s.first_column);
        const float* depth_m = s.layers.depth_m.data() + row;
        const std::uint8_t* labels = s.layers.labels.data() + row;
        float* to_depth_m = scene.depth_m.ptr<float>(y);
        std::uint8_t* to_labels = scene.labels.ptr<std::uint8_t>(y);
        for (int x = box.x; x < box.x + box.width; ++x) {
            to_depth_m[x] = depth_m[x * step];
            to_labels[x] = labels[x * step];
        }
    }
}

// Pixels for which samples first .. last count, of `count`.
cv::Range pixels(int first, int last, int reach, int step, int count) {
    return {std::max(0, (std::max(0, first - reach) + step - 1) / step),
            std::min(count, (last + reach) / step + 1)};
}

}  // namespace

float EyeSamples::depth_m(int x, int y) const {
    x = std::clamp(x, 0, width_px * supersampling - 1) + first_column;
    y = std::clamp(y, 0, height_px * supersampling - 1);
    return layers.depth_m[static_cast<std::size_t>(y) * static_cast<std::size_t>(layers.width) +
                          static_cast<std::size_t>(x)];
}

void update(EyeScene& scene, const EyeSamples& s, double sigma_px, const cv::Rect& box) {
    const cv::Size size(s.width_px, s.height_px);
    scene.linear.create(size, CV_32FC3);
    scene.depth_m.create(size, CV_32F);
    scene.labels.create(size, CV_8U);
    const std::vector<float> weights = kernel(sigma_px, s.supersampling);
    const int reach = static_cast<int>(weights.size() / 2), left = box.x - s.first_column;
    const cv::Range x = pixels(left, left + box.width - 1, reach, s.supersampling, s.width_px);
    const cv::Range y = pixels(box.y, box.y + box.height - 1, reach, s.supersampling, s.height_px);
    if (x.empty() || y.empty()) return;
    const cv::Rect all(x.start, y.start, x.size(), y.size());
    blur(s, weights, all, scene.linear);
    take_centres(s, all, scene);
}

}  // namespace atropos::render
