#include "tracker/end_check.hpp"

#include <algorithm>
#include <cmath>

#include "tracker/instrument_shadow.hpp"

namespace atropos::tracker {
namespace {

/// Median over the points that were seen, grey levels.
double usual_strength(const ImagePath& path) {
    std::vector<double> levels;
    for (const RidgePoint& point : path.points)
        if (point.strength_levels > 0.0) levels.push_back(point.strength_levels);
    if (levels.empty()) return 0.0;
    const auto middle = levels.begin() + static_cast<std::ptrdiff_t>(levels.size() / 2);
    std::nth_element(levels.begin(), middle, levels.end());
    return *middle;
}

/// What lies ahead of an end, by pieces: points of a line that could be the rest of this one, as far as one
/// eye can tell.
using Ahead = std::vector<std::vector<Eigen::Vector2d>>;

Ahead ahead(const ImagePath& path, int end, const std::vector<ImagePath>& pieces,
            const EndCheckOptions& options) {
    constexpr double kSelf_px = 4.0;
    constexpr std::size_t kWorth = 12;  // points of a piece that is more than noise
    const PathEnd here = path_end(path, end == 0);
    const double usual_levels = usual_strength(path);
    const auto is_self = [&](const Eigen::Vector2d& px) {
        return std::any_of(path.points.begin(), path.points.end(),
                           [&](const RidgePoint& p) { return (p.px - px).norm() < kSelf_px; });
    };
    const auto comes_from_here = [&](const RidgePoint& point) {
        const Eigen::Vector2d step = point.px - here.p;
        if (point.strength_levels > options.alike_share * usual_levels && step.norm() < options.near_px)
            return true;
        return point.strength_levels > options.strength_share * usual_levels &&
               step.norm() < options.ahead_px && angle_between(step, here.out) < options.aside_rad &&
               std::abs(step.dot(point.tangent)) > std::cos(options.bend_rad) * step.norm();
    };
    Ahead list;
    for (const ImagePath& piece : pieces) {
        if (piece.points.size() < kWorth) continue;
        std::vector<Eigen::Vector2d> points;
        for (const RidgePoint& point : piece.points)
            if (comes_from_here(point) && !is_self(point.px)) points.push_back(point.px);
        if (!points.empty()) list.push_back(std::move(points));
    }
    return list;
}

/// Whether both eyes see one piece of a line ahead of an end where a thread could come from it.
bool leads_on(const RectifiedView& view, const Eigen::Vector2d& end, double disparity_px,
              const std::array<Ahead, 2>& ahead, const EndCheckOptions& options) {
    constexpr double kRow_px = 1.5, kDisparity_px = 1.5;
    constexpr int kLeast = 6;  // points
    const double slope = options.steepest * std::abs(disparity_px) / view.focal_px();
    const auto is_one = [&](const std::vector<Eigen::Vector2d>& left,
                            const std::vector<Eigen::Vector2d>& right) {
        return std::count_if(left.begin(), left.end(), [&](const Eigen::Vector2d& left_px) {
                   const Eigen::Vector2d p = view.rectified(left_px, 0);
                   const double most = kDisparity_px + slope * (p - end).norm();
                   return std::any_of(right.begin(), right.end(), [&](const Eigen::Vector2d& right_px) {
                       const Eigen::Vector2d q = view.rectified(right_px, 1);
                       return std::abs(p.y() - q.y()) < kRow_px &&
                              std::abs(p.x() - q.x() - disparity_px) < most;
                   });
               }) >= kLeast;
    };
    return std::any_of(ahead[0].begin(), ahead[0].end(), [&](const auto& left) {
        return std::any_of(ahead[1].begin(), ahead[1].end(),
                           [&](const auto& right) { return is_one(left, right); });
    });
}

/// Whether the line passes its own end: it may cross itself in what is hidden.
bool passes_itself(const ImagePath& path, int end) {
    constexpr double kNear_px = 15.0, kApart_px = 60.0;
    const std::vector<double> arc = path.arc_lengths_px();
    const double s = end == 0 ? 0.0 : arc.back();
    for (std::size_t i = 0; i < arc.size(); ++i)
        if (std::abs(arc[i] - s) > kApart_px && (path.points[i].px - path.end(end).px).norm() < kNear_px)
            return true;
    return false;
}

}  // namespace

std::array<bool, 2> ends_are_plain(const RectifiedView& view, const std::array<ImagePath, 2>& path,
                                   bool turned, const std::array<EyeLines, 2>& eyes,
                                   const EndCheckOptions& options) {
    const RectifiedPath left = view.path(path[0], 0, 2.0), right = view.path(path[1], 1, 1.0);
    PairingOptions pairing_options;
    pairing_options.row_sigma_px = 1.2;
    pairing_options.largest_row_px = 3.0;
    const Pairing pairing = pair_paths(view, left, right, 0.0, turned, pairing_options);
    const auto paired = [](int j) { return j >= 0; };
    const auto first = std::find_if(pairing.right.begin(), pairing.right.end(), paired);
    if (first == pairing.right.end()) return {false, false};
    const auto last = std::find_if(pairing.right.rbegin(), pairing.right.rend(), paired);
    const double tail[2][2] = {
        {left.arc_px[static_cast<std::size_t>(first - pairing.right.begin())],
         left.arc_px.back() - left.arc_px[static_cast<std::size_t>(pairing.right.rend() - last - 1)]},
        {right.arc_px[static_cast<std::size_t>(pairing.right_begin)],
         right.arc_px.back() - right.arc_px[static_cast<std::size_t>(pairing.right_end - 1)]}};
    std::array<bool, 2> plain{};
    for (int end = 0; end < 2; ++end) {
        bool hidden = false, leaves = false, itself = false;
        std::array<Ahead, 2> rest;
        double longest = 0.0;
        for (int eye = 0; eye < 2; ++eye) {
            const std::size_t k = static_cast<std::size_t>(eye);
            const int at = eye == 1 && turned ? 1 - end : end;
            hidden |= near_hidden(eyes[k].map, path[k].end(at).px, options.hidden_px);
            leaves |= path[k].leaves_image(at, eyes[k].map.width, eyes[k].map.height);
            rest[k] = ahead(path[k], at, eyes[k].pieces, options);
            itself |= passes_itself(path[k], at);
            longest = std::max(longest, tail[eye][at]);
        }
        const auto i = static_cast<std::size_t>(end == 0 ? first - pairing.right.begin()
                                                         : pairing.right.rend() - last - 1);
        const Eigen::Vector2d& p = left.points[i];
        const double disparity_px = p.x() - right.points[static_cast<std::size_t>(pairing.right[i])].x();
        const bool on = leads_on(view, p, disparity_px, rest, options);
        plain[static_cast<std::size_t>(end)] =
            leaves || (longest < options.tail_px && (hidden || !on) && !(hidden && itself));
    }
    return plain;
}

}  // namespace atropos::tracker
