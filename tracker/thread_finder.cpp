#include "tracker/thread_finder.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tracker/end_check.hpp"
#include "tracker/instrument_shadow.hpp"
#include "tracker/line_edges.hpp"
#include "tracker/line_grower.hpp"
#include "tracker/path_curve.hpp"

namespace atropos::tracker {
namespace {

/// How far the right eye's rows lie lower: the offset of the cheapest pairing.
double paired_row_offset(const RectifiedView& view, const RectifiedPath& left, const RectifiedPath& right,
                         bool turned, double largest_px, const PairingOptions& options) {
    constexpr double kStep_px = 0.5;
    constexpr double kCostPerPx2 = 6.0;  // calibrations are right unless the images say otherwise
    const int half = static_cast<int>(largest_px / kStep_px);
    std::vector<double> cost;
    for (int k = -half; k <= half; ++k)
        cost.push_back(pair_paths(view, left, right, kStep_px * k, turned, options).cost +
                       kCostPerPx2 * kStep_px * kStep_px * k * k);
    const std::size_t best =
        static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
    double shift = 0.0;
    if (best > 0 && best + 1 < cost.size()) {
        const double bend = cost[best - 1] - 2.0 * cost[best] + cost[best + 1];
        if (bend > 1e-9) shift = 0.5 * (cost[best - 1] - cost[best + 1]) / bend;
    }
    return kStep_px * (static_cast<double>(best) - half + std::clamp(shift, -0.5, 0.5));
}

/// Longest stretch of a line along the epipolar line: its depth there is anybody's guess.
double longest_level_px(const RectifiedPath& line) {
    constexpr double kSine = 0.2;
    double longest = 0.0, begin = 0.0;
    for (std::size_t i = 4; i < line.points.size(); ++i) {
        const Eigen::Vector2d along = line.points[i] - line.points[i - 4];
        if (std::abs(along.y()) > kSine * along.norm()) begin = line.arc_px[i];
        longest = std::max(longest, line.arc_px[i] - begin);
    }
    return longest;
}

/// Whether the curve comes to the ends of the lines it was fitted to, in both eyes.
bool reaches_its_ends(const FoundThread& found, bool right_turned) {
    constexpr double kNear_px = 8.0;
    const auto is_near = [&](const Eigen::Vector3d& p_C, int end) {
        const int right_end = right_turned ? 1 - end : end;
        return (found.rig.project_left(p_C) - found.paths[0].end(end).px).norm() < kNear_px &&
               (found.rig.project_right(p_C) - found.paths[1].end(right_end).px).norm() < kNear_px;
    };
    return is_near(found.samples.front().p_C, 0) && is_near(found.samples.back().p_C, 1);
}

}  // namespace

ThreadFinder::ThreadFinder(const scenes::StereoRig& rig, const ThreadFinderOptions& options)
    : rig_(rig), options_(options), view_(rig), detector_(options.ridge), search_(rig, options.search) {}

void ThreadFinder::look(const StereoFrame& frame) {
    for (std::size_t eye = 0; eye < 2; ++eye) {
        EyeLines& lines = eyes_[eye];
        lines.image = channel_view(eye == 0 ? frame.left : frame.right, options_.channel, lines.buffer);
        detector_.detect(lines.image, lines.map);
        hide_instruments(frame.instruments, eye == 0 ? rig_.left : rig_.right,
                         eye == 0 ? Eigen::Isometry3d::Identity() : rig_.X_RC, options_.instrument_margin_px,
                         lines.map);
        lines.pieces = link_lines(lines.map, options_.linker);
    }
}

std::optional<FoundThread> ThreadFinder::find(const StereoFrame& frame,
                                              const std::optional<Eigen::Vector2d>& seed_px) {
    check_frame(frame, rig_);
    look(frame);
    std::optional<ChosenStrand> chosen = search_.search(eyes_, seed_px);
    if (!chosen) return std::nullopt;
    const bool turned = chosen->strand.turned;
    const double offset =
        paired_row_offset(view_, view_.path(chosen->path[0], 0, 4.0), view_.path(chosen->path[1], 1, 1.0),
                          turned, options_.largest_row_offset_px, options_.pairing);
    const double strength = std::min(chosen->path[0].strength(), chosen->path[1].strength());
    const std::array<LineEnd, 2> ends =
        grow_line(view_, eyes_, options_.ridge.polarity, turned, offset, chosen->path, options_.grower);
    const double kept = std::min(chosen->path[0].strength(), chosen->path[1].strength());
    const double rival = std::max(chosen->rival, (strength - kept) / std::max(kept, 1e-9));
    const std::optional<DepthLeap> leap = search_.leap(chosen->path, turned);
    const auto goes_on = [](LineEnd end) {
        return end == LineEnd::kOneEye || end == LineEnd::kItself || end == LineEnd::kFades;
    };
    const std::array<bool, 2> plain = ends_are_plain(view_, chosen->path, turned, eyes_, options_.end_check);
    for (std::size_t eye = 0; eye < 2; ++eye) {
        ImagePath& path = chosen->path[eye];
        std::vector<LineEdges> edges = line_edges(eyes_[eye].image, path, options_.ridge.polarity);
        cut_needles(path, edges, options_.needle_width_ratio);
        centre_between_edges(path, edges);
        reach_instruments(path, eyes_[eye].map, options_.instrument_margin_px);
    }
    std::optional<FoundThread> found = reconstruct(chosen->path[0], chosen->path[1], turned);
    if (!found) return found;
    if (leap)
        found->doubt = Doubt::kLeap;
    else if (rival > options_.largest_rival)
        found->doubt = Doubt::kRival;
    else if (!plain[0] || !plain[1] || goes_on(ends[0]) || goes_on(ends[1]) ||
             !reaches_its_ends(*found, turned))
        found->doubt = Doubt::kEnd;
    else if (longest_level_px(view_.path(found->paths[0], 0, 2.0)) > options_.longest_level_px)
        found->doubt = Doubt::kDepth;
    else if (found->score < options_.least_score)
        found->doubt = Doubt::kFit;
    return found;
}

std::optional<FoundThread> ThreadFinder::reconstruct(ImagePath left, ImagePath right,
                                                     bool right_turned) const {
    const RectifiedPath coarse_left = view_.path(left, 0, 4.0), coarse_right = view_.path(right, 1, 1.0);
    double offset = paired_row_offset(view_, coarse_left, coarse_right, right_turned,
                                      options_.largest_row_offset_px, options_.pairing);
    const RectifiedPath on_left = view_.path(left, 0, 2.0), on_right = view_.path(right, 1, 0.5);
    const Pairing pairing = pair_paths(view_, on_left, on_right, offset, right_turned, options_.pairing);
    TailLimits limits{};
    for (std::size_t end = 0; end < 2; ++end) {
        const int left_end = static_cast<int>(end), right_end = right_turned ? 1 - left_end : left_end;
        const bool left_leaves = left.leaves_image(left_end, rig_.left.width_px, rig_.left.height_px);
        const bool right_leaves = right.leaves_image(right_end, rig_.right.width_px, rig_.right.height_px);
        limits[0][end] = right_leaves ? 1e9 : options_.longest_tail_px;
        limits[1][end] = left_leaves ? 1e9 : options_.longest_tail_px;
    }
    const std::vector<PairedPoint> points =
        paired_points(view_, on_left, on_right, pairing, right_turned, offset, limits);
    const double length_px = on_left.arc_px.back();
    const int K = std::clamp(static_cast<int>(std::lround(length_px / options_.knot_spacing_px)), 8, 64);
    if (static_cast<int>(points.size()) < std::max(K, 10)) return std::nullopt;

    const std::array<ImagePath, 2> paths{std::move(left), std::move(right)};
    const PathCurveOptions fit{
        .control_points = K, .line_sigma_px = options_.line_sigma_px, .row_offset_px = offset};
    const PathCurve curve = fit_to_paths(view_, paths, points, fit);
    std::vector<Eigen::Vector3d> control_points;
    for (int k = 0; k < curve.Q.cols(); ++k) control_points.push_back(curve.Q.col(k));
    for (const Eigen::Vector3d& q : control_points)
        if (!q.allFinite()) return std::nullopt;
    return FoundThread{.curve = NurbsCurve(3, std::move(control_points)),
                       .samples = curve.samples,
                       .length_m = curve.length_m,
                       .row_offset_px = curve.row_offset_px,
                       .rig = view_.with_row_offset(curve.row_offset_px),
                       .score = curve.seen_share / (1.0 + curve.residual_px * curve.residual_px),
                       .residual_px = curve.residual_px,
                       .paths = paths};
}

ThreadFinderOptions finder_options(const scenes::TrackerConfig& config) {
    ThreadFinderOptions options;
    options.channel = config.thread.channel;
    options.ridge.polarity = config.thread.polarity;
    return options;
}

}  // namespace atropos::tracker
