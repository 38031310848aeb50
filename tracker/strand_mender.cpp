#include "tracker/strand_mender.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "tracker/instrument_shadow.hpp"

namespace atropos::tracker {
namespace {

constexpr double kAtEnd_px = 12.0;

Eigen::Vector2d place(const ImagePath& path, const std::vector<double>& arc, double s) {
    const auto at = std::lower_bound(arc.begin(), arc.end(), s);
    const std::ptrdiff_t i = std::min<std::ptrdiff_t>(at - arc.begin(), std::ssize(arc) - 1);
    return path.points[static_cast<std::size_t>(i)].px;
}

/// The join of a path that lies nearest to a place.
std::optional<PathJoin> join_near(const ImagePath& path, const Eigen::Vector2d& px, double reach_px) {
    std::optional<PathJoin> nearest;
    for (const PathJoin& join : path.joins) {
        const double distance = (0.5 * (join.from + join.to) - px).norm();
        if (distance >= reach_px) continue;
        reach_px = distance;
        nearest = join;
    }
    return nearest;
}

/// Where a strand's pairs begin and end along the path of an eye.
struct Section {
    double low, high;
};

Section section(const Strand& strand, std::size_t eye) {
    const auto [low, high] = std::minmax(strand.arc_px[eye].front(), strand.arc_px[eye].back());
    return {low, high};
}

/// The end of a path at `s`, if it is one; else asks for the join that leads on from there to be taken back,
/// or for the piece to be cut.
std::optional<Eigen::Vector2d> end_at(const ImagePath& path, double s, JoinWishes& wishes,
                                      const StrandMenderOptions& options) {
    const std::vector<double> arc = path.arc_lengths_px();
    if (s < kAtEnd_px) return path.points.front().px;
    if (s > arc.back() - kAtEnd_px) return path.points.back().px;
    const Eigen::Vector2d px = place(path, arc, s);
    if (const auto join = join_near(path, px, options.reach_px))
        wishes.forbidden.push_back(*join);
    else
        wishes.cuts.push_back(px);
    return std::nullopt;
}

}  // namespace

StereoWishes mend_leap(const RectifiedView& view, const Strand& strand, const DepthLeap& leap,
                       const StereoPaths& paths, const StrandMenderOptions& options) {
    StereoWishes wishes;
    for (std::size_t eye = 0; eye < 2; ++eye) {
        const Eigen::Vector2d px = view.pixel(eye == 0 ? leap.left : leap.right, static_cast<int>(eye));
        if (const auto join = join_near(paths[eye][strand.path[eye]], px, options.reach_px))
            wishes[eye].forbidden.push_back(*join);
    }
    return wishes;
}

StereoWishes mend_tears(const Strand& strand, const std::vector<Strand>& others, const StereoPaths& paths,
                        const StrandMenderOptions& options) {
    StereoWishes wishes;
    for (const Strand& other : others)
        for (std::size_t whole = 0; whole < 2; ++whole) {
            const std::size_t torn = 1 - whole;
            if (other.path[whole] != strand.path[whole] || other.path[torn] == strand.path[torn]) continue;
            const Section here = section(strand, whole), there = section(other, whole);
            const bool behind = there.low > here.low;
            const double gap = behind ? there.low - here.high : here.low - there.high;
            if (gap < -options.overlap_px || gap > options.gap_px) continue;
            // The pairs are in the left path's order: which of them lies at that end of the whole line?
            const auto is_last = [&](const Strand& s, bool high) {
                return (s.arc_px[whole].back() > s.arc_px[whole].front()) == high;
            };
            const auto torn_place = [&](const Strand& s, bool high) {
                return is_last(s, high) ? s.arc_px[torn].back() : s.arc_px[torn].front();
            };
            const auto disparity = [&](const Strand& s, bool high) {
                return is_last(s, high) ? s.disparity_px.back() : s.disparity_px.front();
            };
            if (std::abs(disparity(strand, behind) - disparity(other, !behind)) > options.leap_px) continue;
            const auto from =
                end_at(paths[torn][strand.path[torn]], torn_place(strand, behind), wishes[torn], options);
            const auto to =
                end_at(paths[torn][other.path[torn]], torn_place(other, !behind), wishes[torn], options);
            if (from && to && (*from - *to).norm() < options.gap_px)
                wishes[torn].wanted.push_back({*from, *to});
        }
    return wishes;
}

StereoWishes mend_ends(const Strand& strand, const StereoPaths& paths,
                       const std::array<const RidgePointMap*, 2>& maps, const StrandMenderOptions& options) {
    constexpr double kHidden_px = 6.0;
    StereoWishes wishes;
    for (std::size_t eye = 0; eye < 2; ++eye) {
        const ImagePath &path = paths[eye][strand.path[eye]], &other = paths[1 - eye][strand.path[1 - eye]];
        const double length = path.arc_lengths_px().back();
        for (const bool last : {false, true}) {
            const auto& mine = strand.arc_px[eye];
            const auto& theirs = strand.arc_px[1 - eye];
            const double s = last ? mine.back() : mine.front(), o = last ? theirs.back() : theirs.front();
            if (s < kAtEnd_px || s > length - kAtEnd_px) continue;
            const double other_length = other.arc_lengths_px().back();
            if (o > kAtEnd_px && o < other_length - kAtEnd_px) continue;
            if (near_hidden(*maps[1 - eye], other.end(o > kAtEnd_px ? 1 : 0).px, kHidden_px))
                end_at(path, s, wishes[eye], options);
        }
    }
    return wishes;
}

}  // namespace atropos::tracker
