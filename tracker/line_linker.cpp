#include "tracker/line_linker.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace atropos::tracker {
namespace {

using Eigen::Vector2d;

constexpr double kLargestTurn = 0.75;  // cosine of the angle from one point to the next

/// Follows ridge points from point to neighbouring point.
class Linker {
  public:
    explicit Linker(const RidgePointMap& map) : map_(map), used_(map.points.size(), false) {}

    std::vector<ImagePath> link(const LineLinkerOptions& options) {
        std::vector<int> order(map_.points.size());
        std::iota(order.begin(), order.end(), 0);
        std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return strength(a) > strength(b); });
        std::vector<ImagePath> pieces;
        for (int start : order) {
            if (strength(start) < options.high_levels) break;
            if (used_[static_cast<std::size_t>(start)]) continue;
            ImagePath piece = follow(start, true);
            piece.reverse();
            const ImagePath ahead = follow(start, false);
            piece.points.insert(piece.points.end(), ahead.points.begin() + 1, ahead.points.end());
            if (static_cast<int>(piece.points.size()) >= options.least_points)
                pieces.push_back(std::move(piece));
        }
        return pieces;
    }

  private:
    double strength(int i) const { return map_.points[static_cast<std::size_t>(i)].strength_levels; }

    ImagePath follow(int start, bool backwards) {
        used_[static_cast<std::size_t>(start)] = true;
        RidgePoint here = map_.points[static_cast<std::size_t>(start)];
        if (backwards) here.tangent = -here.tangent;
        ImagePath piece{{here}};
        while (true) {
            const RidgePoint& last = piece.points.back();
            const int near = successor(last, 1), next = near >= 0 ? near : successor(last, 2);
            if (next < 0) return piece;
            used_[static_cast<std::size_t>(next)] = true;
            RidgePoint point = map_.points[static_cast<std::size_t>(next)];
            if (point.tangent.dot(last.tangent) < 0.0) point.tangent = -point.tangent;
            piece.points.push_back(point);
        }
    }

    /// The unused point on the ring `ring` pixels around that goes on best, -1 = none.
    int successor(const RidgePoint& from, int ring) const {
        const int u = static_cast<int>(std::lround(from.px.x()));
        const int v = static_cast<int>(std::lround(from.px.y()));
        int best = -1;
        double least = 1e9;
        for (int dv = -ring; dv <= ring; ++dv)
            for (int du = -ring; du <= ring; ++du) {
                if (std::max(std::abs(du), std::abs(dv)) != ring) continue;
                const int i = map_.index(u + du, v + dv);
                if (i < 0 || used_[static_cast<std::size_t>(i)]) continue;
                const RidgePoint& to = map_.points[static_cast<std::size_t>(i)];
                const Vector2d step = to.px - from.px;
                const double length = step.norm();
                if (step.dot(from.tangent) < 0.6 * length) continue;
                const double straight = std::abs(to.tangent.dot(from.tangent));
                if (straight < kLargestTurn) continue;
                const double cost = length + 2.0 * std::acos(std::min(1.0, straight));
                if (cost < least) {
                    least = cost;
                    best = i;
                }
            }
        return best;
    }

    const RidgePointMap& map_;
    std::vector<bool> used_;
};

using Cuts = std::vector<std::vector<int>>;  // of each piece, indices of points

/// Where pieces turn sharply.
void cut_at_bends(const std::vector<ImagePath>& pieces, Cuts& cuts) {
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        const std::vector<RidgePoint>& points = pieces[k].points;
        int last = -10;
        for (int i = 3; i + 3 < static_cast<int>(points.size()); ++i) {
            const std::size_t at = static_cast<std::size_t>(i);
            const Vector2d before = points[at].px - points[at - 3].px;
            const Vector2d after = points[at + 3].px - points[at].px;
            if (angle_between(before, after) < 1.3 || i - last < 6) continue;
            cuts[k].push_back(i);
            last = i;
        }
    }
}

/// Where ends of others meet pieces.
void cut_at_meetings(const std::vector<ImagePath>& pieces, const RidgePointMap& map, Cuts& cuts) {
    constexpr int kMeet_px = 4;
    std::vector<std::array<int, 2>> owner(map.at_pixel.size(), {-1, -1});
    for (int k = 0; k < static_cast<int>(pieces.size()); ++k) {
        const std::vector<RidgePoint>& points = pieces[static_cast<std::size_t>(k)].points;
        for (int i = 0; i < static_cast<int>(points.size()); ++i) {
            const Vector2d& p = points[static_cast<std::size_t>(i)].px;
            const int u = std::clamp(static_cast<int>(std::lround(p.x())), 0, map.width - 1);
            const int v = std::clamp(static_cast<int>(std::lround(p.y())), 0, map.height - 1);
            owner[static_cast<std::size_t>(v * map.width + u)] = {k, i};
        }
    }
    for (int k = 0; k < static_cast<int>(pieces.size()); ++k)
        for (const bool front : {true, false}) {
            const PathEnd end = path_end(pieces[static_cast<std::size_t>(k)], front);
            const Vector2d ahead = end.p + 2.0 * end.out;
            std::array<int, 2> met{-1, -1};
            double least = kMeet_px;
            for (int dv = -kMeet_px; dv <= kMeet_px; ++dv)
                for (int du = -kMeet_px; du <= kMeet_px; ++du) {
                    const int u = static_cast<int>(std::lround(ahead.x())) + du;
                    const int v = static_cast<int>(std::lround(ahead.y())) + dv;
                    if (u < 0 || v < 0 || u >= map.width || v >= map.height) continue;
                    const auto [piece, index] = owner[static_cast<std::size_t>(v * map.width + u)];
                    if (piece < 0) continue;
                    const int n = static_cast<int>(pieces[static_cast<std::size_t>(piece)].points.size());
                    if (index < 4 || index >= n - 4) continue;
                    if (piece == k && (front ? index < 12 : index > n - 13)) continue;
                    const double distance = (Vector2d(u, v) - ahead).norm();
                    if (distance >= least) continue;
                    least = distance;
                    met = {piece, index};
                }
            if (met[0] >= 0) cuts[static_cast<std::size_t>(met[0])].push_back(met[1]);
        }
}

/// The parts between the cuts, without the points next to them: a crossing has bent those.
std::vector<ImagePath> parts(const std::vector<ImagePath>& pieces, Cuts& cuts, int least_points) {
    constexpr int kMargin = 2;
    std::vector<ImagePath> parts;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        const std::vector<RidgePoint>& points = pieces[k].points;
        const int n = static_cast<int>(points.size());
        std::sort(cuts[k].begin(), cuts[k].end());
        int from = 0;
        const auto add = [&](int begin, int end) {
            if (end - begin >= least_points)
                parts.push_back({{points.begin() + begin, points.begin() + end}});
        };
        for (int i : cuts[k]) {
            add(from, std::max(from, i - kMargin));
            from = std::min(n, std::max(from, i + kMargin + 1));
        }
        add(from, n);
    }
    return parts;
}

}  // namespace

std::vector<ImagePath> link_lines(const RidgePointMap& map, const LineLinkerOptions& options) {
    const std::vector<ImagePath> pieces = Linker(map).link(options);
    Cuts cuts(pieces.size());
    cut_at_bends(pieces, cuts);
    cut_at_meetings(pieces, map, cuts);
    return parts(pieces, cuts, options.least_points);
}

}  // namespace atropos::tracker
