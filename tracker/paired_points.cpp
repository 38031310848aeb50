#include "tracker/paired_points.hpp"

#include <algorithm>
#include <cmath>

namespace atropos::tracker {
namespace {

using Eigen::Vector2d;

/// Disparities smoothed over neighbours, each weighed by the square of the sine to the epipolar line.
std::vector<double> smoothed(const std::vector<double>& disparity, const std::vector<double>& weight) {
    constexpr double kEnough = 8.0;
    constexpr int kLeastHalf = 6, kMostHalf = 50;
    const int n = static_cast<int>(disparity.size());
    std::vector<double> out(disparity.size());
    for (int i = 0; i < n; ++i) {
        // Weighted line through the neighbours: no bias at the ends or on a slope.
        double w = 0.0, wt = 0.0, wtt = 0.0, wd = 0.0, wtd = 0.0;
        // As far as it takes to know something: along the epipolar line, far.
        int half = kLeastHalf;
        double known = 0.0;
        for (int k = 0; k <= kMostHalf && (k <= kLeastHalf || known < kEnough); ++k) {
            half = k;
            if (i - k >= 0) known += weight[static_cast<std::size_t>(i - k)];
            if (i + k < n && k > 0) known += weight[static_cast<std::size_t>(i + k)];
        }
        for (int k = std::max(0, i - half); k <= std::min(n - 1, i + half); ++k) {
            const double g = weight[static_cast<std::size_t>(k)], t = k - i,
                         d = disparity[static_cast<std::size_t>(k)];
            w += g;
            wt += g * t;
            wtt += g * t * t;
            wd += g * d;
            wtd += g * t * d;
        }
        wtt += 20.0 * w;  // towards no slope: the end of a line is badly known
        out[static_cast<std::size_t>(i)] = (wtt * wd - wt * wtd) / (wtt * w - wt * wt);
    }
    return out;
}

/// Change of a sequence a step outwards at one of its ends, by least squares over the outermost values.
double slope_at(const std::vector<double>& values, bool front) {
    const int n = static_cast<int>(values.size()), count = std::min(20, n);
    if (count < 5) return 0.0;
    double st = 0.0, stt = 0.0, sd = 0.0, std = 0.0;
    for (int k = 0; k < count; ++k) {
        const double d = values[static_cast<std::size_t>(front ? k : n - 1 - k)];
        st += k;
        stt += k * k;
        sd += d;
        std += k * d;
    }
    return -(count * std - st * sd) / (count * stt - st * st);
}

}  // namespace

std::vector<PairedPoint> paired_points(const RectifiedView& view, const RectifiedPath& left,
                                       const RectifiedPath& right, const Pairing& pairing, bool right_turned,
                                       double row_offset_px, const TailLimits& limits) {
    std::vector<int> index;  // of the left points that are paired
    std::vector<double> disparity, weight;
    const int n = static_cast<int>(left.points.size()), m = static_cast<int>(right.points.size());
    for (int i = 0; i < n; ++i) {
        const int j = pairing.right[static_cast<std::size_t>(i)];
        if (j < 0) continue;
        const Vector2d& p = left.points[static_cast<std::size_t>(i)];
        const Vector2d along = left.points[static_cast<std::size_t>(std::min(i + 2, n - 1))] -
                               left.points[static_cast<std::size_t>(std::max(i - 2, 0))];
        const double sine = along.y() / std::max(along.norm(), 1e-9);
        index.push_back(i);
        disparity.push_back(p.x() - right.points[static_cast<std::size_t>(j)].x());
        weight.push_back(sine * sine + 0.002);
    }
    std::vector<PairedPoint> points;
    if (index.size() < 2) return points;
    disparity = smoothed(disparity, weight);
    const double least = 0.5 * *std::min_element(disparity.begin(), disparity.end());
    const auto left_arc = [&](int i) { return left.arc_px[static_cast<std::size_t>(i)]; };
    const auto right_arc = [&](int j) { return right.arc_px[static_cast<std::size_t>(j)]; };
    const auto add = [&](const Vector2d& p, double d, double on_left, double on_right) {
        points.push_back({view.point(p, std::max(d, least)), {on_left, on_right}});
    };
    const double step = left.arc_px[1];
    // What one eye alone sees before the first pair (front) or behind the last, outermost point first.
    const auto tail = [&](bool front) {
        const double slope = slope_at(disparity, front) / step;
        const double d0 = front ? disparity.front() : disparity.back();
        const int i0 = front ? index.front() : index.back();
        for (int i = front ? 0 : n - 1; i != i0; i += front ? 1 : -1)
            if (std::abs(left_arc(i) - left_arc(i0)) <= limits[0][front ? 0 : 1])
                add(left.points[static_cast<std::size_t>(i)],
                    d0 + slope * std::abs(left_arc(i) - left_arc(i0)), left_arc(i), -1.0);
        if (i0 != (front ? 0 : n - 1)) return;
        const bool low = front != right_turned;  // whether it is the right path's beginning
        const int j0 = low ? pairing.right_begin : pairing.right_end - 1;
        const int stride = std::max(1, static_cast<int>(std::lround(step / right.arc_px[1])));
        const int outermost = low ? j0 % stride : j0 + (m - 1 - j0) / stride * stride;
        for (int j = outermost; j != j0; j += low ? stride : -stride) {
            if (std::abs(right_arc(j) - right_arc(j0)) > limits[1][front ? 0 : 1]) continue;
            const double d = d0 + slope * std::abs(right_arc(j) - right_arc(j0));
            const Vector2d& q = right.points[static_cast<std::size_t>(j)];
            add({q.x() + std::max(d, least), q.y() - row_offset_px}, d, -1.0, right_arc(j));
        }
    };
    tail(true);
    for (std::size_t k = 0; k < index.size(); ++k)
        add(left.points[static_cast<std::size_t>(index[k])], disparity[k], left_arc(index[k]),
            right_arc(pairing.right[static_cast<std::size_t>(index[k])]));
    const std::ptrdiff_t paired = static_cast<std::ptrdiff_t>(points.size());
    tail(false);
    std::reverse(points.begin() + paired, points.end());
    return points;
}

}  // namespace atropos::tracker
