#include "sim/knotted_curve.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace atropos::sim {

using Eigen::Vector3d;

namespace {

constexpr double kKnotShare = 0.4;  ///< of the length lies in the knot
constexpr double kEnd = 2.15;       ///< of the polynomial's parameter, beyond all crossings

/// Knot of `length_m`, its ends along `along`, both rising.
scenes::Polyline trefoil(const Vector3d& along, const Vector3d& up, double length_m) {
    scenes::Polyline knot;
    for (int i = -400; i <= 400; ++i) {
        const double t = kEnd * i / 400;
        knot.points.push_back(
            {t * (t * t - 3), 0.45 * (t * t * t * t - 4 * t * t), 0.5 * (std::pow(t, 5) / 5 - 2 * t)});
    }
    const Vector3d x = (knot.points.back() - knot.points.front()).normalized(), y = Vector3d::UnitY();
    const double scale = length_m / knot.length_m();
    const Vector3d lift = knot.points.front().y() * y;  // origin between the ends
    for (Vector3d& p : knot.points) {
        const Vector3d q = scale * (p - lift);
        p = q.dot(x) * along + q.dot(y) * up + q.dot(x.cross(y)) * along.cross(up);
    }
    return knot;
}

/// Cubic from `a` to `b`, without both.
void connect(const Vector3d& a, const Vector3d& t_a, const Vector3d& b, const Vector3d& t_b,
             scenes::Polyline& curve) {
    const double reach = (b - a).norm();
    for (int i = 1; i < 100; ++i) {
        const double u = i / 100.0, v = 1.0 - u;
        curve.points.push_back(v * v * (1 + 2 * u) * a + u * u * (1 + 2 * v) * b +
                               reach * (u * v * v * t_a - u * u * v * t_b));
    }
}

}  // namespace

scenes::Polyline knotted_curve(const CurveEnd& first, const CurveEnd& last, double length_m) {
    const Vector3d up = Vector3d::UnitZ();
    Vector3d along = last.p_W - first.p_W;
    along = (along - along.dot(up) * up).normalized();
    const scenes::Polyline knot = trefoil(along, up, kKnotShare * length_m);
    const auto hung = [&](double depth_m) {
        scenes::Polyline placed = knot, curve;
        for (Vector3d& p : placed.points) p += 0.5 * (first.p_W + last.p_W) - depth_m * up;
        const auto& k = placed.points;
        curve.points.push_back(first.p_W);
        connect(first.p_W, first.tangent_W.normalized(), k.front(), (k[1] - k[0]).normalized(), curve);
        curve.points.insert(curve.points.end(), k.begin(), k.end());
        connect(k.back(), (k[k.size() - 1] - k[k.size() - 2]).normalized(), last.p_W,
                last.tangent_W.normalized(), curve);
        curve.points.push_back(last.p_W);
        return curve;
    };
    double low = 0.0, high = length_m;
    if (hung(low).length_m() > length_m)
        throw std::invalid_argument(
            "thread of " + std::to_string(1e3 * length_m) + " mm is too short for a loose knot over " +
            std::to_string(1e3 * (last.p_W - first.p_W).norm()) + " mm, expected a longer thread");
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (hung(middle).length_m() < length_m ? low : high) = middle;
    }
    return hung(low);
}

}  // namespace atropos::sim
