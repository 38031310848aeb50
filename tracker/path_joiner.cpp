#include "tracker/path_joiner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace atropos::tracker {
namespace {

using Eigen::Vector2d;

constexpr double kLongestOverlap_px = 10.0;

struct Join {
    int a = 0, b = 0;  ///< ends: 2 * piece + (0 front, 1 back)
    double cost = 0.0;
};

bool is_hidden(const RidgePointMap& map, const Vector2d& from, const Vector2d& to) {
    const int steps = static_cast<int>((to - from).norm()) + 1;
    for (int i = 0; i <= steps; ++i) {
        const Vector2d p = from + static_cast<double>(i) / steps * (to - from);
        if (map.index(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y()))) ==
            RidgePointMap::kHidden)
            return true;
    }
    return false;
}

/// What a join costs; infinite where there can be none.
double join_cost(const PathEnd& a, const PathEnd& b, const RidgePointMap& map,
                 const PathJoinerOptions& options) {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    const double gap = (b.p - a.p).norm();
    if (gap > options.reach_px) return kNever;
    // A gloss along the line splits it: two ends may run beside each other for some pixels.
    const bool overlap = gap > 1.5 && (b.p - a.p).dot(a.out - b.out) < 0.0;
    if (overlap && gap > kLongestOverlap_px) return kNever;
    const Vector2d across = overlap ? Vector2d(b.far - a.far) : Vector2d(b.inner - a.inner);
    if (across.norm() < 1e-6) return kNever;
    const double bend_a = angle_between(a.out, across), bend_b = angle_between(-b.out, across);
    const double cost =
        gap / options.gap_px + (bend_a * bend_a + bend_b * bend_b) / (options.bend_rad * options.bend_rad);
    return cost < options.dearest_join && !is_hidden(map, a.p, b.p) ? cost : kNever;
}

bool is_same(const PathJoin& join, const Vector2d& a, const Vector2d& b) {
    constexpr double kSame2_px2 = 4.0;
    return ((join.from - a).squaredNorm() < kSame2_px2 && (join.to - b).squaredNorm() < kSame2_px2) ||
           ((join.from - b).squaredNorm() < kSame2_px2 && (join.to - a).squaredNorm() < kSame2_px2);
}

bool is_among(const std::vector<PathJoin>& joins, const Vector2d& a, const Vector2d& b) {
    return std::any_of(joins.begin(), joins.end(), [&](const PathJoin& j) { return is_same(j, a, b); });
}

std::vector<Join> possible_joins(const std::vector<PathEnd>& ends, const RidgePointMap& map,
                                 const PathJoinerOptions& options, const JoinWishes& wishes) {
    std::vector<Join> joins;
    for (std::size_t a = 0; a < ends.size(); ++a)
        for (std::size_t b = a + 2 - a % 2; b < ends.size(); ++b) {  // never both ends of one piece
            const double cost = is_among(wishes.wanted, ends[a].p, ends[b].p)
                                    ? -1.0
                                    : join_cost(ends[a], ends[b], map, options);
            if (std::isfinite(cost) && !is_among(wishes.forbidden, ends[a].p, ends[b].p))
                joins.push_back({static_cast<int>(a), static_cast<int>(b), cost});
        }
    std::stable_sort(joins.begin(), joins.end(),
                     [](const Join& x, const Join& y) { return x.cost < y.cost; });
    return joins;
}

/// Partner of each end, -1 = free; the cheapest joins first, never to a ring.
std::vector<int> partners(std::size_t pieces, const std::vector<Join>& joins) {
    std::vector<int> partner(2 * pieces, -1), root(pieces);
    std::iota(root.begin(), root.end(), 0);
    const auto find = [&](int k) {
        while (root[static_cast<std::size_t>(k)] != k) k = root[static_cast<std::size_t>(k)];
        return k;
    };
    for (const Join& join : joins) {
        if (partner[static_cast<std::size_t>(join.a)] >= 0 || partner[static_cast<std::size_t>(join.b)] >= 0)
            continue;
        const int ra = find(join.a / 2), rb = find(join.b / 2);
        if (ra == rb) continue;
        root[static_cast<std::size_t>(std::max(ra, rb))] = std::min(ra, rb);
        partner[static_cast<std::size_t>(join.a)] = join.b;
        partner[static_cast<std::size_t>(join.b)] = join.a;
    }
    return partner;
}

/// Cubic Hermite bridge between the last point and the first of what follows; strength 0.
void bridge(ImagePath& path, const RidgePoint& to) {
    const RidgePoint from = path.points.back();
    const double gap = (to.px - from.px).norm();
    const int steps = static_cast<int>(gap);
    for (int i = 1; i < steps; ++i) {
        const double t = static_cast<double>(i) / steps, s = 1.0 - t;
        RidgePoint point;
        point.px = s * s * (1.0 + 2.0 * t) * from.px + t * t * (3.0 - 2.0 * t) * to.px +
                   gap * t * s * (s * from.tangent - t * to.tangent);
        point.tangent = (s * from.tangent + t * to.tangent).normalized();
        path.points.push_back(point);
    }
}

/// Where the path has run past the beginning of what follows, drops what lies past it on both sides.
void take_overlap_away(ImagePath& path, ImagePath& next) {
    std::vector<RidgePoint>& piece = next.points;
    const auto past = [&] {
        const Vector2d step = piece.front().px - path.points.back().px;
        return step.dot(path.points.back().tangent + piece.front().tangent) < 0.0;
    };
    for (int i = 0; i < 12 && path.points.size() > 4 && piece.size() > 4 && past(); ++i) {
        path.points.pop_back();
        piece.erase(piece.begin());
    }
}

ImagePath path_from(const std::vector<ImagePath>& pieces, const std::vector<int>& partner, int end,
                    std::vector<bool>& done) {
    ImagePath path;
    while (end >= 0) {
        const std::size_t k = static_cast<std::size_t>(end / 2);
        done[k] = true;
        ImagePath piece = pieces[k];
        if (end % 2 == 1) piece.reverse();
        if (!path.points.empty()) {
            path.joins.push_back({path.points.back().px, piece.points.front().px});
            take_overlap_away(path, piece);
            bridge(path, piece.points.front());
        }
        path.points.insert(path.points.end(), piece.points.begin(), piece.points.end());
        end = partner[static_cast<std::size_t>(end ^ 1)];
    }
    return path;
}

}  // namespace

std::optional<PathJoin> cut_piece(std::vector<ImagePath>& pieces, const Vector2d& px) {
    constexpr double kNear2_px2 = 9.0;
    constexpr int kMargin = 3, kLeast = 8;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        std::vector<RidgePoint>& points = pieces[k].points;
        const int n = static_cast<int>(points.size());
        for (int i = kLeast; i + kLeast < n; ++i) {
            if ((points[static_cast<std::size_t>(i)].px - px).squaredNorm() > kNear2_px2) continue;
            ImagePath rest{{points.begin() + i + kMargin, points.end()}};
            points.resize(static_cast<std::size_t>(i - kMargin));
            const PathJoin cut{points.back().px, rest.points.front().px};
            pieces.push_back(std::move(rest));
            return cut;
        }
    }
    return std::nullopt;
}

std::vector<ImagePath> join_pieces(const std::vector<ImagePath>& pieces, const RidgePointMap& map,
                                   const PathJoinerOptions& options, const JoinWishes& wishes) {
    std::vector<PathEnd> ends;
    for (const ImagePath& piece : pieces)
        for (const bool front : {true, false}) ends.push_back(path_end(piece, front));
    const std::vector<int> partner = partners(pieces.size(), possible_joins(ends, map, options, wishes));
    std::vector<ImagePath> paths;
    std::vector<bool> done(pieces.size(), false);
    for (int end = 0; end < static_cast<int>(ends.size()); ++end)
        if (partner[static_cast<std::size_t>(end)] < 0 && !done[static_cast<std::size_t>(end / 2)])
            paths.push_back(path_from(pieces, partner, end, done));
    std::stable_sort(paths.begin(), paths.end(),
                     [](const ImagePath& a, const ImagePath& b) { return a.strength() > b.strength(); });
    return paths;
}

}  // namespace atropos::tracker
