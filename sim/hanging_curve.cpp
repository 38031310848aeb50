#include "sim/hanging_curve.hpp"

#include <stdexcept>

namespace atropos::sim {

using Eigen::Vector3d;

namespace {

/// Bezier curve whose inner control points lie `reach` along the end directions and `sag` further down.
scenes::Polyline bezier(const CurveEnd& first, const CurveEnd& last, double reach, double sag,
                        const Vector3d& down, int points) {
    const Vector3d b1 = first.p_W + reach * first.tangent_W, b4 = last.p_W - reach * last.tangent_W;
    const Vector3d b2 = b1 + sag * down, b3 = b4 + sag * down;
    scenes::Polyline curve;
    for (int i = 0; i < points; ++i) {
        const double u = double(i) / (points - 1), v = 1.0 - u;
        curve.points.push_back(v * v * v * v * v * first.p_W + 5 * u * v * v * v * v * b1 +
                               10 * u * u * v * v * v * b2 + 10 * u * u * u * v * v * b3 +
                               5 * u * u * u * u * v * b4 + u * u * u * u * u * last.p_W);
    }
    return curve;
}

}  // namespace

scenes::Polyline hanging_curve(const CurveEnd& first, const CurveEnd& last, double length_m, int points,
                               const Vector3d& down_W) {
    const double chord = (last.p_W - first.p_W).norm();
    if (!(length_m > chord))
        throw std::invalid_argument("thread of " + std::to_string(1e3 * length_m) + " mm cannot span " +
                                    std::to_string(1e3 * chord) + " mm, expected a longer thread");
    const CurveEnd a{first.p_W, first.tangent_W.normalized()}, b{last.p_W, last.tangent_W.normalized()};
    const Vector3d down = down_W.normalized();
    // The sag that gives the length; where the ends' reach alone is too long already, a shorter reach.
    double reach = 0.15 * length_m;
    while (bezier(a, b, reach, 0.0, down, points).length_m() > length_m && reach > 1e-3 * length_m)
        reach *= 0.7;
    double low = 0.0, high = 8.0 * length_m;
    for (int i = 0; i < 80; ++i) {
        const double sag = 0.5 * (low + high);
        (bezier(a, b, reach, sag, down, points).length_m() < length_m ? low : high) = sag;
    }
    return bezier(a, b, reach, low, down, points).resampled(points);
}

}  // namespace atropos::sim
