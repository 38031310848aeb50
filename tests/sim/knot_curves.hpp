#pragma once

#include <cmath>
#include <vector>

#include "scenes/polyline.hpp"

namespace atropos::sim::testing {

/// A loose overhand knot between two straight tails: the polynomial trefoil (t^3 - 3t, t^4 - 4t^2, t^5/5 -
/// 2t).
inline scenes::Polyline loose_overhand(double length_m) {
    scenes::Polyline knot;
    for (int i = -400; i <= 400; ++i) {
        const double t = 2.15 * i / 400;
        knot.points.push_back(
            {t * (t * t - 3), 0.45 * (t * t * t * t - 4 * t * t), 0.5 * (std::pow(t, 5) / 5 - 2 * t)});
    }
    auto& p = knot.points;
    const double tail = knot.length_m() / 3;
    const Eigen::Vector3d d0 = (p[1] - p[0]).normalized(), d1 = (p[800] - p[799]).normalized();
    p.insert(p.begin(), p.front() - tail * d0);
    p.push_back(p.back() + tail * d1);
    const double scale = length_m / knot.length_m();
    for (auto& q : p) q *= scale;
    return knot;
}

/// A loose square knot in one thread: two bights through one another, the lower legs joined in a wide loop.
/// The free ends point along -x and +x, the loop's bottom is at the middle of the length.
inline scenes::Polyline loose_square_knot(double unit_m) {
    // One bight: in from x = -12, round its nose at x = 2.6, out again; over, under, over, over, under, over.
    std::vector<Eigen::Vector3d> bight;
    const auto height = [](double x) {
        return std::abs(x) < 2.45 ? -std::cos(M_PI * x / 2.45) : (x > 0 ? 1.0 : std::exp(-(-x - 2.45)));
    };
    for (int i = 0; i <= 264; ++i) {
        const double x = -12 + i * 0.05;
        bight.push_back({x, 1.0 + 0.4 * std::tanh(1.5 * x), height(x)});
    }
    for (int i = 1; i < 60; ++i) {
        const double a = M_PI / 2 - M_PI * i / 60;
        bight.push_back({1.2 + 1.4 * std::cos(a), 1.4 * std::sin(a), height(1.2 + 1.4 * std::cos(a))});
    }
    for (int i = 264; i >= 0; --i)
        bight.push_back({bight[static_cast<size_t>(i)].x(), -bight[static_cast<size_t>(i)].y(),
                         bight[static_cast<size_t>(i)].z()});
    scenes::Polyline knot;
    knot.points = bight;
    const Eigen::Vector3d from = bight.back();
    const double radius = -from.x();
    for (int i = 1; i < 200; ++i) {  // the loop, from (-12, -0.6) round below to (12, -0.6)
        const double a = M_PI + M_PI * i / 200;
        knot.points.push_back({radius * std::cos(a), from.y() + 1.6 * radius * std::sin(a), 0.0});
    }
    for (auto p = bight.rbegin(); p != bight.rend(); ++p) knot.points.push_back({-p->x(), p->y(), -p->z()});
    for (auto& q : knot.points) q *= unit_m;
    return knot;
}

}  // namespace atropos::sim::testing
