#pragma once

#include <cmath>

#include "scenes/polyline.hpp"

namespace atropos::robot {

/// Catenary of the given length between two points at equal height, hanging along -z; 101 points. A real
/// thread is stiffer and hangs less.
inline scenes::Polyline hanging_thread(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double length_m) {
    const double half = 0.5 * (b - a).norm();
    double low = 1e-4, high = 10.0;  // of the catenary's parameter: length = 2 c sinh(half / c)
    for (int i = 0; i < 200; ++i) {
        const double c = 0.5 * (low + high);
        (2.0 * c * std::sinh(half / c) > length_m ? low : high) = c;
    }
    scenes::Polyline thread;
    for (int i = 0; i <= 100; ++i) {
        const double s = length_m * (i / 100.0 - 0.5), x = low * std::asinh(s / low);
        const double drop = low * (std::cosh(half / low) - std::cosh(x / low));
        thread.points.push_back(0.5 * (a + b) + x / (2.0 * half) * (b - a) - drop * Eigen::Vector3d::UnitZ());
    }
    return thread;
}

}  // namespace atropos::robot
