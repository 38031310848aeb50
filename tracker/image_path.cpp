#include "tracker/image_path.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace atropos::tracker {

std::vector<double> ImagePath::arc_lengths_px() const {
    std::vector<double> arc(points.size(), 0.0);
    for (std::size_t i = 1; i < points.size(); ++i)
        arc[i] = arc[i - 1] + (points[i].px - points[i - 1].px).norm();
    return arc;
}

double ImagePath::strength() const {
    double sum = 0.0;
    for (const RidgePoint& p : points) sum += p.strength_levels;
    return sum;
}

void ImagePath::reverse() {
    std::reverse(points.begin(), points.end());
    for (RidgePoint& p : points) p.tangent = -p.tangent;
    std::reverse(joins.begin(), joins.end());
    for (PathJoin& join : joins) std::swap(join.from, join.to);
}

bool ImagePath::leaves_image(int which, int width, int height, double margin_px) const {
    const Eigen::Vector2d& p = end(which).px;
    return p.x() < margin_px || p.y() < margin_px || p.x() > width - 1 - margin_px ||
           p.y() > height - 1 - margin_px;
}

PathEnd path_end(const ImagePath& path, bool front) {
    constexpr int kReach = 7, kFar = 14;
    const int n = static_cast<int>(path.points.size());
    const auto at = [&](int i) -> const RidgePoint& {
        return path.points[static_cast<std::size_t>(front ? std::min(i, n - 1) : std::max(0, n - 1 - i))];
    };
    const int reach = std::min(kReach, n - 1);
    PathEnd end{at(0).px, at(std::min(3, n - 1)).px, at(kFar).px};
    // The chord of the last points, turned on by half of what they turn.
    const Eigen::Vector2d outer = at(0).px - at(reach / 2).px;
    const Eigen::Vector2d inner = at(reach / 2).px - at(reach).px;
    const Eigen::Vector2d chord = (at(0).px - at(reach).px).normalized();
    const double turn =
        reach >= 6 ? std::clamp(std::atan2(inner.x() * outer.y() - inner.y() * outer.x(), inner.dot(outer)),
                                -0.5, 0.5)
                   : 0.0;
    end.out = Eigen::Rotation2Dd(0.5 * turn) * chord;
    return end;
}

double angle_between(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return std::abs(std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b)));
}

}  // namespace atropos::tracker
