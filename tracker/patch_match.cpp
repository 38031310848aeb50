#include "tracker/patch_match.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace atropos::tracker {
namespace {

constexpr double kBlur_px = 1.0;                                        ///< against noise and aliasing
constexpr std::array<float, 3> kTaps = {0.40262f, 0.24420f, 0.05448f};  ///< of it: centre and to each side
constexpr int kReach = 2;
constexpr int kStride = 3;  ///< between centres that are tried
constexpr double kLeastCorrelation = 0.7;
constexpr double kMostMove_px = 1.5;
constexpr int kIterations = 8;

float tapped(const float* p, std::ptrdiff_t step) {
    return kTaps[0] * p[0] + kTaps[1] * (p[-step] + p[step]) + kTaps[2] * (p[-2 * step] + p[2 * step]);
}

}  // namespace

// `region` with kReach pixels about it lies in the image.
void PatchMatcher::blur(const ImageView& image, const cv::Rect& region, Window& out) {
    out.at = region;
    const int width = region.width + 2 * kReach, height = region.height + 2 * kReach;
    raw_.create(height, width);
    half_blurred_.create(height, region.width);
    out.grey.create(region.size());
    for (int v = 0; v < height; ++v) {
        float* row = raw_[v];
        for (int u = 0; u < width; ++u) row[u] = image.at(region.x - kReach + u, region.y - kReach + v);
        float* half = half_blurred_[v];
        for (int u = 0; u < region.width; ++u) half[u] = tapped(row + u + kReach, 1);
    }
    for (int v = 0; v < region.height; ++v) {
        const float* half = half_blurred_[v + kReach];
        float* row = out.grey[v];
        for (int u = 0; u < region.width; ++u) row[u] = tapped(half + u, region.width);
    }
}

std::optional<cv::Point> PatchMatcher::choose(const ImageView& left, const cv::Rect& cell) {
    constexpr int kBorder = kHalf + 1;
    const int margin = kBorder + kReach;
    const cv::Rect whole(margin, margin, left.width - 2 * margin, left.height - 2 * margin);
    const cv::Rect centres = cell & whole;
    if (centres.empty()) return std::nullopt;
    blur(
        left,
        {centres.x - kBorder, centres.y - kBorder, centres.width + 2 * kBorder, centres.height + 2 * kBorder},
        left_);
    // Sums over all that lies above and to the left, of squared gradients.
    const int width = left_.at.width - 1, height = left_.at.height - 1;
    for (cv::Mat1d* sums : {&sums_xx_, &sums_xy_, &sums_yy_}) {
        sums->create(height, width);
        sums->row(0).setTo(0.0);
        sums->col(0).setTo(0.0);
    }
    for (int v = 1; v < height; ++v)
        for (int u = 1; u < width; ++u) {
            const double x = 0.5 * (left_.grey(v, u + 1) - left_.grey(v, u - 1));
            const double y = 0.5 * (left_.grey(v + 1, u) - left_.grey(v - 1, u));
            const auto add = [u, v](cv::Mat1d& sums, double value) {
                sums(v, u) = value + sums(v - 1, u) + sums(v, u - 1) - sums(v - 1, u - 1);
            };
            add(sums_xx_, x * x);
            add(sums_xy_, x * y);
            add(sums_yy_, y * y);
        }
    std::optional<cv::Point> best;
    double most = 0.0;
    for (int v = 0; v < centres.height; v += kStride)
        for (int u = 0; u < centres.width; u += kStride) {
            const auto sum = [u, v](const cv::Mat1d& sums) {
                return sums(v + kSide, u + kSide) - sums(v, u + kSide) - sums(v + kSide, u) + sums(v, u);
            };
            const double xy = sum(sums_xy_);
            const double information = sum(sums_yy_) - xy * xy / (sum(sums_xx_) + 1e-3);
            if (!(information > most)) continue;
            most = information;
            best = centres.tl() + cv::Point(u, v);
        }
    if (best) describe(*best);
    return best;
}

void PatchMatcher::describe(const cv::Point& centre) {
    centre_px_ = {centre.x, centre.y};
    const cv::Point corner = centre - cv::Point(kHalf, kHalf) - left_.at.tl();
    for (int v = 0; v < kSide; ++v)
        for (int u = 0; u < kSide; ++u) {
            const int n = v * kSide + u, y = corner.y + v, x = corner.x + u;
            grey_[n] = left_.grey(y, x);
            by_x_[n] = 0.5f * (left_.grey(y, x + 1) - left_.grey(y, x - 1));
            by_y_[n] = 0.5f * (left_.grey(y + 1, x) - left_.grey(y - 1, x));
        }
    for (Values* values : {&grey_, &by_x_, &by_y_}) *values -= values->mean();
    normal_matrix_ << by_x_.square().sum(), (by_x_ * by_y_).sum(), 0.0, by_y_.square().sum();
    normal_matrix_(1, 0) = normal_matrix_(0, 1);
    normal_matrix_.diagonal().array() += 1e-6;
}

std::optional<PatchMatch> PatchMatcher::find(const ImageView& right, const cv::Rect& region) {
    constexpr int kBorder = kHalf + 2;  // a patch may move by a pixel and a half
    const int margin = kBorder + kReach;
    const cv::Rect whole(margin, margin, right.width - 2 * margin, right.height - 2 * margin);
    const cv::Rect centres = region & whole;
    if (centres.width < 3 || centres.height < 3) return std::nullopt;
    blur(
        right,
        {centres.x - kBorder, centres.y - kBorder, centres.width + 2 * kBorder, centres.height + 2 * kBorder},
        right_);
    const std::optional<cv::Point> first = best_correlated();
    return first ? refine(*first) : std::nullopt;
}

// The centre in `right_`. A peak at the border is the slope of one that lies beyond it.
std::optional<cv::Point> PatchMatcher::best_correlated() const {
    const int border = kHalf + 2;
    const cv::Rect centres(border, border, right_.at.width - 2 * border, right_.at.height - 2 * border);
    constexpr int kUsed = (kHalf + 1) * kSide;
    double patch_sum = 0.0, patch_power = 0.0;
    for (int v = 0; v < kSide; v += 2)
        for (int u = 0; u < kSide; ++u) {
            patch_sum += grey_[v * kSide + u];
            patch_power += grey_[v * kSide + u] * grey_[v * kSide + u];
        }
    patch_power -= patch_sum * patch_sum / kUsed;
    double best = kLeastCorrelation;
    cv::Point at(-1, -1);
    for (int y = centres.y; y < centres.br().y; ++y)
        for (int x = centres.x; x < centres.br().x; ++x) {
            std::array<float, kSide> sums{}, squares{}, products{};  // of columns
            for (int v = 0; v < kSide; v += 2) {  // the blur makes rows much like their neighbours
                const float* row = right_.grey[y - kHalf + v] + x - kHalf;
                const float* patch = grey_.data() + v * kSide;
                for (std::size_t u = 0; u < kSide; ++u) {
                    sums[u] += row[u];
                    squares[u] += row[u] * row[u];
                    products[u] += row[u] * patch[u];
                }
            }
            const auto total = [](const std::array<float, kSide>& columns) {
                return std::accumulate(columns.begin(), columns.end(), 0.0);
            };
            const double sum = total(sums), product = total(products) - sum * patch_sum / kUsed;
            const double power = total(squares) - sum * sum / kUsed;
            const double correlation = product / std::sqrt(std::max(power * patch_power, 1e-6));
            if (!(correlation > best)) continue;
            best = correlation;
            at = {x, y};
        }
    if (at.x <= centres.x || at.y <= centres.y || at.x >= centres.br().x - 1 || at.y >= centres.br().y - 1)
        return std::nullopt;
    return at;
}

std::optional<PatchMatch> PatchMatcher::refine(const cv::Point& first) const {
    const Eigen::Matrix2d inverse = normal_matrix_.inverse();
    Eigen::Vector2d moved = Eigen::Vector2d::Zero();
    Values seen;
    double squares = 0.0;
    for (int i = 0; i < kIterations; ++i) {
        const double x = first.x - kHalf + moved.x(), y = first.y - kHalf + moved.y();
        const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
        const float fx = static_cast<float>(x - x0), fy = static_cast<float>(y - y0);
        for (int v = 0; v < kSide; ++v) {
            const float* p = right_.grey[y0 + v] + x0;
            const float* q = right_.grey[y0 + v + 1] + x0;
            float* out = seen.data() + v * kSide;
            for (int u = 0; u < kSide; ++u) {
                const float top = p[u] + fx * (p[u + 1] - p[u]);
                out[u] = top + fy * (q[u] + fx * (q[u + 1] - q[u]) - top);
            }
        }
        seen -= seen.mean();
        const float gain = (seen * grey_).sum() / (seen.square().sum() + 1e-6f);
        seen = gain * seen - grey_;
        squares = seen.square().sum();
        const Eigen::Vector2d pull((seen * by_x_).sum(), (seen * by_y_).sum());
        const Eigen::Vector2d step = -inverse * pull;
        moved += step;
        if (!(moved.lpNorm<Eigen::Infinity>() < kMostMove_px)) return std::nullopt;
        if (step.norm() < 1e-3) break;
    }
    // Of white noise the blur leaves 1 / (4 pi s^2), and of its slope 1 / (8 pi s^4): that half of what
    // differs makes gradients of its own, which tell nothing.
    const double s2 = kBlur_px * kBlur_px;
    const double variance = squares / kCount * 4.0 * std::numbers::pi * s2;
    const double by_noise = 0.5 * variance / (8.0 * std::numbers::pi * s2 * s2) * kCount;
    PatchMatch match;
    match.left_px = centre_px_;
    match.right_px = moved + Eigen::Vector2d(first.x + right_.at.x, first.y + right_.at.y);
    match.information = (normal_matrix_ - by_noise * Eigen::Matrix2d::Identity()) / (variance + 1e-9);
    return match;
}

}  // namespace atropos::tracker
