#include "tracker/valley_filter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tracker/normal_profile.hpp"

namespace atropos::tracker {
namespace {

void insert(const Valley& valley, std::array<Valley, ValleyFilter::kMaxValleys>& valleys, int& count) {
    int at = count;
    while (at > 0 && valleys[static_cast<std::size_t>(at - 1)].depth_levels < valley.depth_levels) {
        if (at < ValleyFilter::kMaxValleys)
            valleys[static_cast<std::size_t>(at)] = valleys[static_cast<std::size_t>(at - 1)];
        --at;
    }
    if (at < ValleyFilter::kMaxValleys) valleys[static_cast<std::size_t>(at)] = valley;
    count = std::min(count + 1, ValleyFilter::kMaxValleys);
}

/// Valleys of sign * profile.
void find_in(const NormalProfile& profile, float sign, int side, int smooth, int reach, double step_px,
             double threshold, std::array<Valley, ValleyFilter::kMaxValleys>& valleys, int& count) {
    NormalProfile mean;  // box of the thread's width: noise falls, a highlight on the thread is averaged away
    mean.half = profile.half;
    const int first = profile.first + smooth;
    const int last = profile.last - smooth;
    const float scale = sign / static_cast<float>(2 * smooth + 1);
    for (int i = first; i <= last; ++i) {
        float sum = 0.0f;
        for (int j = -smooth; j <= smooth; ++j) sum += profile[i + j];
        mean[i] = scale * sum;
    }
    const auto response = [&](int i) { return 0.5f * (mean[i - side] + mean[i + side]) - mean[i]; };
    const int from = std::max(-reach, first + side + 1);
    const int to = std::min(reach, last - side - 1);
    for (int i = from; i <= to; ++i) {
        const float depth = std::min(mean[i - side], mean[i + side]) - mean[i];
        if (depth < static_cast<float>(threshold)) continue;
        const float before = response(i - 1);
        const float here = response(i);
        const float after = response(i + 1);
        if (here < before || here <= after) continue;
        const float curvature = before - 2.0f * here + after;
        const double shift = curvature < 0.0f ? 0.5 * static_cast<double>((before - after) / curvature) : 0.0;
        insert({(i + shift) * step_px, static_cast<double>(depth)}, valleys, count);
    }
}

/// Correlation of the noise of neighbours in a profile: linear interpolation between pixels of white noise
/// leaves 2/3 of its variance and 1/6 between neighbours, on average over all places between pixels.
constexpr double kSharedNoise = 0.25;

double blurred_bar(double t, double half_width, double blur) {
    const double k = 1.0 / (std::numbers::sqrt2 * blur);
    return 0.5 * (std::erf((half_width - t) * k) + std::erf((half_width + t) * k));
}

double blurred_bar_slope(double t, double half_width, double blur) {
    const auto bell = [blur](double x) {
        return std::exp(-0.5 * x * x / (blur * blur)) / (blur * std::sqrt(2.0 * std::numbers::pi));
    };
    return bell(half_width + t) - bell(half_width - t);
}

}  // namespace

int ValleyFilter::find(const ImageView& image, const NormalLine& line, double search_px, double width_px,
                       std::array<Valley, kMaxValleys>& valleys, double threshold_share) const {
    const double step = std::max(1.0, width_px / 4.0);
    const int smooth = std::max(1, static_cast<int>(std::lround(0.3 * width_px / step))) - (width_px < 1.5);
    const int side = std::max(smooth + 1, static_cast<int>(std::lround((0.5 * width_px + 1.2) / step)) + 1);
    const int reach = static_cast<int>(std::ceil(search_px / step));
    NormalProfile profile;
    profile.read(image, line, step, reach + side + smooth + 1, options_.taps, options_.tap_step_px);
    const double threshold = threshold_share * options_.threshold_levels;
    int count = 0;
    if (options_.polarity != scenes::ThreadPolarity::kBright)
        find_in(profile, 1.0f, side, smooth, reach, step, threshold, valleys, count);
    if (options_.polarity != scenes::ThreadPolarity::kDark)
        find_in(profile, -1.0f, side, smooth, reach, step, threshold, valleys, count);
    return count;
}

// g(t) = B0 + B1 t - A bar(t - o). On a window that is even about t = 0 the even part of g holds B0 and A,
// the odd part B1 and, to first order, a = A o by the derivative of the bar: two systems of two unknowns.
bool ValleyFilter::localise(const ImageView& image, const NormalLine& line, double width_px,
                            Localisation& found) const {
    const int half = std::min(static_cast<int>(std::ceil(0.5 * width_px + 2.5 * options_.blur_px + 0.5)), 24);
    NormalProfile profile;
    profile.read(image, line, 1.0, half, options_.taps, options_.tap_step_px);
    if (profile.first > -half || profile.last < half) return false;

    double bar_1 = 0.0, bar_bar = 0.0, g_1 = 0.0, g_bar = 0.0;                     // even
    double t_t = 0.0, t_slope = 0.0, slope_slope = 0.0, g_t = 0.0, g_slope = 0.0;  // odd
    std::array<double, 49> bar{}, slope{};
    const int n = 2 * half + 1;
    for (int i = -half; i <= half; ++i) {
        const std::size_t at = static_cast<std::size_t>(i + half);
        bar[at] = blurred_bar(i, 0.5 * width_px, options_.blur_px);
        slope[at] = blurred_bar_slope(i, 0.5 * width_px, options_.blur_px);
        const double g = static_cast<double>(profile[i]);
        bar_1 += bar[at];
        bar_bar += bar[at] * bar[at];
        g_1 += g;
        g_bar += g * bar[at];
        t_t += i * i;
        t_slope += i * slope[at];
        slope_slope += slope[at] * slope[at];
        g_t += g * i;
        g_slope += g * slope[at];
    }
    const double even = n * bar_bar - bar_1 * bar_1;
    const double odd = t_t * slope_slope - t_slope * t_slope;
    if (even < 1e-9 || odd < 1e-9) return false;
    const double level = (g_1 * bar_bar - g_bar * bar_1) / even;
    const double A = (g_1 * bar_1 - n * g_bar) / even;  // of -A bar
    const double tilt = (g_t * slope_slope - g_slope * t_slope) / odd;
    const double a = (g_slope * t_t - g_t * t_slope) / odd;
    const bool dark_wanted = options_.polarity != scenes::ThreadPolarity::kBright;
    const bool bright_wanted = options_.polarity != scenes::ThreadPolarity::kDark;
    if (!((A > 0.0 && dark_wanted) || (A < 0.0 && bright_wanted))) return false;

    double left_over = 0.0, squares = 0.0, products = 0.0, weight_before = 0.0;
    double fitted = 0.0;  // of the noise that neighbours share
    for (int i = -half; i <= half; ++i) {
        const std::size_t at = static_cast<std::size_t>(i + half);
        const double model = level + tilt * i - A * bar[at] + a * slope[at];
        left_over += std::pow(static_cast<double>(profile[i]) - model, 2);
        const double weight = (slope[at] * t_t - i * t_slope) / odd;  // of g in a
        squares += weight * weight;
        products += weight * weight_before;
        weight_before = weight;
        if (i == -half) continue;
        const double b = bar[at - 1], d = slope[at - 1];
        fitted +=
            (bar_bar - bar_1 * (b + bar[at]) + n * b * bar[at]) / even +
            (t_t * d * slope[at] - t_slope * ((i - 1) * slope[at] + i * d) + slope_slope * (i - 1) * i) / odd;
    }
    found.offset_px = a / A;
    found.contrast_levels = std::abs(A);
    found.noise_levels = std::sqrt(left_over / (n - 4 - 2.0 * kSharedNoise * fitted));
    found.contrast_sigma_levels = found.noise_levels * std::sqrt(n / even);
    found.sigma_px_per_noise_level = std::sqrt(squares + 2.0 * kSharedNoise * products) / std::abs(A);
    return true;
}

}  // namespace atropos::tracker
