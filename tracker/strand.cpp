#include "tracker/strand.hpp"

#include <algorithm>
#include <cmath>

namespace atropos::tracker {
namespace {

struct Range {
    double low = 1e18, high = -1e18;
};

Range rows(const RectifiedPath& path) {
    Range range;
    for (const Eigen::Vector2d& p : path.points) {
        range.low = std::min(range.low, p.y());
        range.high = std::max(range.high, p.y());
    }
    return range;
}

/// Share of the longer of two row ranges that both have, the rows' offset allowed for.
double overlap(const Range& a, const Range& b, double slack_px) {
    const double both = std::min(a.high, b.high) - std::max(a.low, b.low) + slack_px;
    return both / (std::max(a.high - a.low, b.high - b.low) + slack_px);
}

/// Median of what lies within [low, high] of an ordered place; nothing of less than five values.
std::optional<double> median_within(const std::vector<double>& place, const std::vector<double>& value,
                                    double low, double high) {
    const auto begin = std::lower_bound(place.begin(), place.end(), low);
    const auto end = std::upper_bound(begin, place.end(), high);
    if (end - begin < 5) return std::nullopt;
    std::vector<double> some(value.begin() + (begin - place.begin()), value.begin() + (end - place.begin()));
    const auto middle = some.begin() + static_cast<std::ptrdiff_t>(some.size() / 2);
    std::nth_element(some.begin(), middle, some.end());
    return *middle;
}

}  // namespace

Strand paired_strand(const RectifiedPath& left, const RectifiedPath& right, const Pairing& pairing) {
    Strand strand;
    for (std::size_t i = 0; i < left.points.size(); ++i) {
        if (pairing.right[i] < 0) continue;
        strand.left.push_back(left.points[i]);
        const std::size_t j = static_cast<std::size_t>(pairing.right[i]);
        strand.disparity_px.push_back(left.points[i].x() - right.points[j].x());
        strand.arc_px[0].push_back(left.arc_px[i]);
        strand.arc_px[1].push_back(right.arc_px[j]);
    }
    return strand;
}

std::vector<Strand> strands(const RectifiedView& view, const StereoPaths& paths,
                            const StrandOptions& options) {
    std::vector<RectifiedPath> lines[2];
    for (std::size_t eye = 0; eye < 2; ++eye)
        for (const ImagePath& path : paths[eye])
            lines[eye].push_back(view.path(path, static_cast<int>(eye), eye == 0 ? 4.0 : 2.0));
    std::vector<Strand> list;
    for (std::size_t l = 0; l < lines[0].size(); ++l) {
        if (lines[0][l].arc_px.back() < options.least_length_px) continue;
        for (std::size_t r = 0; r < lines[1].size(); ++r) {
            if (overlap(rows(lines[0][l]), rows(lines[1][r]), options.pairing.largest_row_px) <
                options.least_row_overlap)
                continue;
            for (const bool turned : {false, true}) {
                const RectifiedPath &left = lines[0][l], &right = lines[1][r];
                const Pairing pairing = pair_paths(view, left, right, 0.0, turned, options.pairing);
                if (!std::isfinite(pairing.cost)) continue;
                Strand strand = paired_strand(left, right, pairing);
                strand.path = {l, r};
                strand.turned = turned;
                const double share_left =
                    static_cast<double>(strand.left.size()) / static_cast<double>(left.points.size());
                const double share_right = static_cast<double>(pairing.right_end - pairing.right_begin) /
                                           static_cast<double>(right.points.size());
                strand.strength =
                    std::min(share_left * paths[0][l].strength(), share_right * paths[1][r].strength()) *
                    (1.0 - pairing.mean_row_px / 2.0);
                if (strand.strength > 0.0) list.push_back(std::move(strand));
            }
        }
    }
    std::stable_sort(list.begin(), list.end(),
                     [](const Strand& a, const Strand& b) { return a.strength > b.strength; });
    return list;
}

std::optional<DepthLeap> depth_leap(const RectifiedView& view, const Strand& strand,
                                    const GroundDepth& ground, double standing_px) {
    constexpr double kNear_px = 4.0, kFar_px = 24.0;  // of the windows before and behind
    constexpr double kSteepest = 2.1;                 // slope to the image plane: 65 degrees
    constexpr double kAnywhere = 1.6;                 // times that, where no ground is needed to tell
    constexpr double kSine = 0.35;                    // along the epipolar line, disparity is unknown
    std::vector<double> arc, disparity;
    std::vector<Eigen::Vector2d> left;
    for (std::size_t i = 0; i < strand.left.size(); ++i) {
        const Eigen::Vector2d along =
            strand.left[std::min(i + 2, strand.left.size() - 1)] - strand.left[i < 2 ? 0 : i - 2];
        if (std::abs(along.y()) < kSine * along.norm()) continue;
        arc.push_back(strand.arc_px[0][i]);
        disparity.push_back(strand.disparity_px[i]);
        left.push_back(strand.left[i]);
    }
    double most = 1.0;
    std::optional<DepthLeap> place;
    for (std::size_t i = 0; i < arc.size(); ++i) {
        const double s = arc[i];
        const auto before = median_within(arc, disparity, s - kFar_px, s - kNear_px);
        const auto behind = median_within(arc, disparity, s + kNear_px, s + kFar_px);
        if (!before || !behind) continue;
        // A thread that leaves the image plane at 45 degrees changes by baseline / depth a px.
        const double mean = 0.5 * (*before + *behind);
        const double usual = (kFar_px + kNear_px) * mean / view.focal_px();
        const double leap = std::abs(*behind - *before) / (kSteepest * usual + 0.5);
        if (leap <= most) continue;
        if (leap < kAnywhere) {
            const std::optional<double> level = ground.disparity_px(left[i]);
            if (!level || std::min(*before, *behind) > *level + 0.5 * standing_px ||
                std::max(*before, *behind) < *level + standing_px)
                continue;
        }
        most = leap;
        place = {left[i], left[i] - Eigen::Vector2d(mean, 0.0)};
    }
    return place;
}

std::optional<double> standing_share(const Strand& strand, const GroundDepth& ground, double least_px) {
    std::size_t known = 0, standing = 0;
    for (std::size_t i = 0; i < strand.left.size(); ++i)
        if (const std::optional<double> d = ground.disparity_px(strand.left[i])) {
            ++known;
            if (strand.disparity_px[i] - *d > least_px) ++standing;
        }
    if (known == 0 || 3 * known < strand.left.size()) return std::nullopt;
    return static_cast<double>(standing) / static_cast<double>(known);
}

}  // namespace atropos::tracker
