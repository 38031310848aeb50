#include "scenes/polyline.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace atropos::scenes {

double Polyline::length_m() const {
    double length = 0.0;
    for (size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).norm();
    return length;
}

std::vector<double> Polyline::arc_lengths_m() const {
    std::vector<double> s(points.size(), 0.0);
    for (size_t i = 1; i < points.size(); ++i) s[i] = s[i - 1] + (points[i] - points[i - 1]).norm();
    return s;
}

namespace {

Eigen::Vector3d interpolate(const std::vector<Eigen::Vector3d>& points, const std::vector<double>& s,
                            double at) {
    if (at <= 0.0 || points.size() == 1) return points.front();
    if (at >= s.back()) return points.back();
    const auto i = static_cast<size_t>(std::upper_bound(s.begin(), s.end(), at) - s.begin());
    const double t = (at - s[i - 1]) / (s[i] - s[i - 1]);
    return (1.0 - t) * points[i - 1] + t * points[i];
}

}  // namespace

Eigen::Vector3d Polyline::point_at(double s_m) const {
    if (points.empty()) throw std::invalid_argument("Polyline::point_at: no points");
    return interpolate(points, arc_lengths_m(), s_m);
}

Polyline Polyline::resampled(int count) const {
    if (points.empty() || count < 2)
        throw std::invalid_argument("Polyline::resampled: needs points and count >= 2");
    const std::vector<double> s = arc_lengths_m();
    Polyline result;
    result.points.reserve(static_cast<size_t>(count));
    for (int i = 0; i < count; ++i)
        result.points.push_back(interpolate(points, s, s.back() * i / (count - 1)));
    return result;
}

Polyline::Nearest Polyline::nearest(const Eigen::Vector3d& p) const {
    if (points.empty()) throw std::invalid_argument("Polyline::nearest: no points");
    Nearest best{points.front(), 0.0, (p - points.front()).norm()};
    double s = 0.0;
    for (size_t i = 1; i < points.size(); ++i) {
        const Eigen::Vector3d edge = points[i] - points[i - 1];
        const double length = edge.norm();
        const double t =
            length > 0.0 ? std::clamp((p - points[i - 1]).dot(edge) / (length * length), 0.0, 1.0) : 0.0;
        const Eigen::Vector3d q = points[i - 1] + t * edge;
        const double distance = (p - q).norm();
        if (distance < best.distance_m) best = {q, s + t * length, distance};
        s += length;
    }
    return best;
}

}  // namespace atropos::scenes
