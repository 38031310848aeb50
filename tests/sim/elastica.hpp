#pragma once

#include <array>
#include <cmath>
#include <vector>

namespace atropos::sim::testing {

/// A plane rod as an ordinary differential equation, solved here by itself: angle, curvature, x, z over s.
using RodOde = std::array<double, 4>;

/// EI th'' = H sin th - w (s - s_free) cos th: internal force (H, w (s - s_free)), weight w a metre, angle th
/// above the horizontal. Fourth-order Runge-Kutta; returns all points.
inline std::vector<RodOde> integrate_elastica(double EI, double H, double w, double s_free, RodOde y,
                                              double length, int steps = 4000) {
    const auto f = [&](double s, const RodOde& v) {
        return RodOde{v[1], (H * std::sin(v[0]) - w * (s - s_free) * std::cos(v[0])) / EI, std::cos(v[0]),
                      std::sin(v[0])};
    };
    const auto plus = [](const RodOde& a, double h, const RodOde& b) {
        return RodOde{a[0] + h * b[0], a[1] + h * b[1], a[2] + h * b[2], a[3] + h * b[3]};
    };
    const double h = length / steps;
    std::vector<RodOde> points{y};
    for (int i = 0; i < steps; ++i) {
        const double s = i * h;
        const RodOde k1 = f(s, y), k2 = f(s + h / 2, plus(y, h / 2, k1)),
                     k3 = f(s + h / 2, plus(y, h / 2, k2)), k4 = f(s + h, plus(y, h, k3));
        y = plus(plus(plus(plus(y, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
        points.push_back(y);
    }
    return points;
}

}  // namespace atropos::sim::testing
