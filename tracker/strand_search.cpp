#include "tracker/strand_search.hpp"

#include <algorithm>

namespace atropos::tracker {
namespace {

bool is_near(const ImagePath& path, const Eigen::Vector2d& px, double reach_px) {
    return std::any_of(path.points.begin(), path.points.end(),
                       [&](const RidgePoint& p) { return (p.px - px).norm() < reach_px; });
}

bool is_among(const std::vector<PathJoin>& joins, const PathJoin& join) {
    return std::any_of(joins.begin(), joins.end(),
                       [&](const PathJoin& j) { return j.from == join.from && j.to == join.to; });
}

/// Of the strands that have at least `share` of the first one's strength: faint pairings may be anywhere.
double largest_disparity_px(const std::vector<Strand>& strands, double share) {
    double largest = 0.0;
    for (const Strand& s : strands) {
        if (s.strength < share * strands[0].strength) break;
        std::vector<double> d = s.disparity_px;
        const auto high = d.begin() + static_cast<std::ptrdiff_t>(d.size() * 9 / 10);
        std::nth_element(d.begin(), high, d.end());
        largest = std::max(largest, *high);
    }
    return largest;
}

bool have_nothing_in_common(const Strand& a, const Strand& b) {
    return a.path[0] != b.path[0] && a.path[1] != b.path[1];
}

}  // namespace

StereoPaths StrandSearch::joined(const std::array<EyeLines, 2>& eyes,
                                 const std::optional<Eigen::Vector2d>& seed_px) const {
    StereoPaths paths;
    for (std::size_t eye = 0; eye < 2; ++eye) {
        paths[eye] = join_pieces(eyes[eye].pieces, eyes[eye].map, options_.joiner, wishes_[eye]);
        std::erase_if(paths[eye], [&](const ImagePath& p) {
            return static_cast<double>(p.points.size()) < 0.5 * options_.strand.least_length_px;
        });
        if (paths[eye].size() > static_cast<std::size_t>(options_.candidates))
            paths[eye].resize(static_cast<std::size_t>(options_.candidates));
    }
    if (seed_px)
        std::erase_if(paths[0],
                      [&](const ImagePath& p) { return !is_near(p, *seed_px, options_.seed_reach_px); });
    return paths;
}

std::optional<ChosenStrand> StrandSearch::choose(const std::array<EyeLines, 2>& eyes,
                                                 const StereoPaths& paths) {
    const std::vector<Strand> list = strands(view_, paths, options_.strand);
    if (list.empty()) return std::nullopt;
    // Only where lines vie does it matter what they lie on.
    const bool vie = std::any_of(list.begin(), list.end(), [&](const Strand& s) {
        return have_nothing_in_common(s, list[0]) && s.strength > options_.rival_share * list[0].strength;
    });
    if (vie && !ground_.has_looked())
        ground_.look({eyes[0].image, eyes[0].map, paths[0]}, {eyes[1].image, eyes[1].map, paths[1]},
                     options_.strand.pairing.farthest_m, largest_disparity_px(list, options_.rival_share));
    std::vector<double> standing(list.size(), 1.0);
    std::size_t best = 0;
    const auto weight = [&](std::size_t k) {
        return std::max(standing[k], options_.lying_weight) * list[k].strength;
    };
    for (std::size_t k = 0; k < list.size(); ++k) {
        if (ground_.has_looked())
            standing[k] = standing_share(list[k], ground_, options_.standing_px).value_or(1.0);
        if (weight(k) > weight(best)) best = k;
    }
    ChosenStrand chosen{
        .strand = list[best], .path = {}, .weight = weight(best), .leap = {}, .companions = {}};
    for (std::size_t eye = 0; eye < 2; ++eye) chosen.path[eye] = paths[eye][list[best].path[eye]];
    for (std::size_t k = 0; k < list.size(); ++k) {
        if (have_nothing_in_common(list[k], list[best]))
            chosen.rival = std::max(chosen.rival, weight(k) / weight(best));
        if (k != best && standing[k] > options_.companion_share) chosen.companions.push_back(list[k]);
    }
    chosen.leap = leap(chosen.path, chosen.strand.turned);
    return chosen;
}

std::optional<DepthLeap> StrandSearch::leap(const std::array<ImagePath, 2>& path, bool turned) const {
    const RectifiedPath left = view_.path(path[0], 0, 2.0), right = view_.path(path[1], 1, 1.0);
    const Pairing pairing = pair_paths(view_, left, right, 0.0, turned, options_.strand.pairing);
    return depth_leap(view_, paired_strand(left, right, pairing), ground_, options_.standing_px);
}

// Whether there was anything new in it.
bool StrandSearch::learn(const StereoWishes& wishes, std::array<EyeLines, 2>& eyes) {
    bool learnt = false;
    for (std::size_t eye = 0; eye < 2; ++eye) {
        JoinWishes& known = wishes_[eye];
        const auto add = [&](const std::vector<PathJoin>& joins, std::vector<PathJoin>& to) {
            for (const PathJoin& join : joins) {
                if (is_among(known.forbidden, join) || is_among(known.wanted, join)) continue;
                to.push_back(join);
                learnt = true;
            }
        };
        add(wishes[eye].forbidden, known.forbidden);
        add(wishes[eye].wanted, known.wanted);
        for (const Eigen::Vector2d& px : wishes[eye].cuts)
            if (const std::optional<PathJoin> cut = cut_piece(eyes[eye].pieces, px))
                add({*cut}, known.forbidden);
    }
    return learnt;
}

std::optional<ChosenStrand> StrandSearch::search(std::array<EyeLines, 2>& eyes,
                                                 const std::optional<Eigen::Vector2d>& seed_px) {
    ground_.forget();
    wishes_ = {};
    std::optional<ChosenStrand> best;
    for (int attempt = 0; attempt < options_.attempts; ++attempt) {
        const StereoPaths paths = joined(eyes, seed_px);
        const std::optional<ChosenStrand> next = choose(eyes, paths);
        if (!next) break;
        // What stands off the ground counts, so that nothing is lost with what a thread ran on into.
        if (!best || next->weight > best->weight ||
            (best->leap && !next->leap && next->weight > 0.9 * best->weight))
            best = next;
        const StrandMenderOptions& mender = options_.mender;
        bool learnt = next->leap && learn(mend_leap(view_, next->strand, *next->leap, paths, mender), eyes);
        learnt |= learn(mend_tears(next->strand, next->companions, paths, mender), eyes);
        learnt |= learn(mend_ends(next->strand, paths, {&eyes[0].map, &eyes[1].map}, mender), eyes);
        if (!learnt) break;
    }
    return best;
}

}  // namespace atropos::tracker
