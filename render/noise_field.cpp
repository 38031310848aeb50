#include "render/noise_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/random_stream.hpp"

namespace atropos::render {

NoiseField::NoiseField(std::uint64_t seed, std::string_view name)
    : seed_(static_cast<std::uint32_t>(scenes::RandomStream(seed, name).next())) {}

inline std::uint32_t NoiseField::hash(int x, int y) const {
    std::uint32_t h =
        seed_ ^ (static_cast<std::uint32_t>(x) * 0x8da6b343u) ^ (static_cast<std::uint32_t>(y) * 0xd8163841u);
    h = (h ^ (h >> 16)) * 0x7feb352du;
    h = (h ^ (h >> 15)) * 0x846ca68bu;
    return h ^ (h >> 16);
}

inline float NoiseField::gradient(int x, int y, float dx, float dy) const {
    constexpr float d = 0.70710678f;
    static constexpr std::array<float, 16> kDirections = {1, 0, -1, 0, 0, 1,  0,  -1,
                                                          d, d, -d, d, d, -d, -d, -d};
    const std::size_t i = 2 * (hash(x, y) >> 29);
    return kDirections[i] * dx + kDirections[i + 1] * dy;
}

// std::lerp's care for infinities costs more than the rest of the noise.
static float mix(float a, float b, float t) {
    return a + t * (b - a);
}

inline float NoiseField::smooth_at(float x, float y) const {
    const float fx = std::floor(x), fy = std::floor(y), u = x - fx, v = y - fy;
    const int ix = static_cast<int>(fx), iy = static_cast<int>(fy);
    const auto ease = [](float t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); };
    const float su = ease(u), sv = ease(v);
    const float low = mix(gradient(ix, iy, u, v), gradient(ix + 1, iy, u - 1.0f, v), su);
    const float high =
        mix(gradient(ix, iy + 1, u, v - 1.0f), gradient(ix + 1, iy + 1, u - 1.0f, v - 1.0f), su);
    return 1.4f * mix(low, high, sv);
}

float NoiseField::smooth(float x, float y) const {
    return smooth_at(x, y);
}

float NoiseField::fractal(float x, float y, int octaves) const {
    float sum = 0.0f, weight = 0.5f;
    for (int i = 0; i < octaves; ++i) {
        sum += weight * smooth(x, y);
        weight *= 0.5f;
        // Turned as well as halved, so that the lattices don't show.
        const float turned = 1.6f * x + 1.2f * y;
        y = 1.6f * y - 1.2f * x + 17.3f;
        x = turned;
    }
    return sum;
}

std::vector<float> NoiseField::fractal(std::span<const float> x, float y, int octaves) const {
    std::vector<float> sum(x.size(), 0.0f), at_x(x.begin(), x.end()), at_y(x.size(), y);
    float weight = 0.5f;
    for (int i = 0; i < octaves; ++i, weight *= 0.5f) {
        for (std::size_t k = 0; k < x.size(); ++k) {
            sum[k] += weight * smooth_at(at_x[k], at_y[k]);
            const float turned = 1.6f * at_x[k] + 1.2f * at_y[k];
            at_y[k] = 1.6f * at_y[k] - 1.2f * at_x[k] + 17.3f;
            at_x[k] = turned;
        }
    }
    return sum;
}

NoiseField::Cells NoiseField::cells(float x, float y) const {
    const int ix = static_cast<int>(std::floor(x)), iy = static_cast<int>(std::floor(y));
    float nearest = 9.0f, second = 9.0f;
    for (int cy = iy - 1; cy <= iy + 1; ++cy) {
        for (int cx = ix - 1; cx <= ix + 1; ++cx) {
            const std::uint32_t h = hash(cx, cy);
            const float px = static_cast<float>(cx) + static_cast<float>(h & 0xffffu) / 65536.0f;
            const float py = static_cast<float>(cy) + static_cast<float>(h >> 16) / 65536.0f;
            const float d2 = (px - x) * (px - x) + (py - y) * (py - y);
            second = std::min(second, std::max(nearest, d2));
            nearest = std::min(nearest, d2);
        }
    }
    return {std::sqrt(nearest), std::sqrt(second)};
}

}  // namespace atropos::render
