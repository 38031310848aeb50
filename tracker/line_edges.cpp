#include "tracker/line_edges.hpp"

#include <algorithm>
#include <cmath>

#include "tracker/normal_profile.hpp"

namespace atropos::tracker {
namespace {

constexpr double kStep_px = 0.5;
constexpr int kGround = 5;  // profile values beyond the reach that make the ground's level

double median(std::vector<double> values) {
    if (values.empty()) return 0.0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// A profile, turned so that the line is darker than the ground on both sides.
struct Section {
    NormalProfile profile;
    double ground[2] = {0.0, 0.0};  ///< low side, high side
    double depth = 0.0;             ///< of the darkest place near the middle under the nearer ground
    double unrest = 0.0;            ///< mean absolute deviation of the ground from its level
    bool whole = false;
};

Section section(const ImageView& image, const RidgePoint& point, bool bright, int reach) {
    Section s;
    s.profile.read(image, {point.px, {-point.tangent.y(), point.tangent.x()}, point.tangent}, kStep_px,
                   reach + kGround, 3, 1.0);
    s.whole = s.profile.first <= -reach - 2 && s.profile.last >= reach + 2;
    if (!s.whole) return s;
    const float sign = bright ? -1.0f : 1.0f;
    for (int i = s.profile.first; i <= s.profile.last; ++i) s.profile[i] *= sign;
    const auto ground = [&](int from, int to) {
        std::vector<double> levels;
        for (int i = from; i <= to; ++i) levels.push_back(static_cast<double>(s.profile[i]));
        return median(std::move(levels));
    };
    s.ground[0] = ground(s.profile.first, -reach);
    s.ground[1] = ground(reach, s.profile.last);
    for (int i = 0; i < kGround; ++i)
        s.unrest += (std::abs(static_cast<double>(s.profile[s.profile.first + i]) - s.ground[0]) +
                     std::abs(static_cast<double>(s.profile[s.profile.last - i]) - s.ground[1])) /
                    (2.0 * kGround);
    float darkest = s.profile[0];
    for (int i = -3; i <= 3; ++i) darkest = std::min(darkest, s.profile[i]);
    s.depth = std::min(s.ground[0], s.ground[1]) - static_cast<double>(darkest);
    return s;
}

/// Offset at which the profile first falls below `level`, from outside inwards on one side.
bool crossing(const NormalProfile& profile, int reach, int side, double level, double& offset_px) {
    for (int k = reach; k > -reach; --k) {
        const double outer = static_cast<double>(profile[side * k]);
        const double inner = static_cast<double>(profile[side * (k - 1)]);
        if (inner >= level) continue;
        const double share = outer <= level ? 0.0 : (outer - level) / (outer - inner);
        offset_px = side * kStep_px * (k - share);
        return outer > level;
    }
    return false;
}

}  // namespace

std::vector<LineEdges> line_edges(const ImageView& image, const ImagePath& path,
                                  scenes::ThreadPolarity polarity, double reach_px) {
    const int reach = static_cast<int>(reach_px / kStep_px);
    std::vector<Section> sections;
    std::vector<double> depths, unrests;
    const bool bright = polarity == scenes::ThreadPolarity::kBright;
    for (const RidgePoint& point : path.points) {
        sections.push_back(section(image, point, bright, reach));
        if (!sections.back().whole || point.strength_levels <= 0.0) continue;
        depths.push_back(sections.back().depth);
        unrests.push_back(sections.back().unrest);
    }
    const double depth = median(depths), level = 0.35 * depth, foot = 0.12 * depth;
    const bool even_ground = foot > 8.0 * median(unrests);
    std::vector<LineEdges> edges(path.points.size());
    if (level <= 0.0) return edges;
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const Section& s = sections[i];
        LineEdges& e = edges[i];
        e.found = even_ground && s.whole && crossing(s.profile, reach, -1, s.ground[0] - level, e.low_px) &&
                  crossing(s.profile, reach, 1, s.ground[1] - level, e.high_px) && e.width_px() > 0.3;
        double low = 0.0, high = 0.0;
        if (s.whole && even_ground && crossing(s.profile, reach, -1, s.ground[0] - foot, low) &&
            crossing(s.profile, reach, 1, s.ground[1] - foot, high))
            e.foot_width_px = std::max(0.0, high - low);
    }
    return edges;
}

bool cut_needles(ImagePath& path, std::vector<LineEdges>& edges, double ratio) {
    std::vector<double> widths;
    for (const LineEdges& e : edges)
        if (e.foot_width_px > 0.0) widths.push_back(e.foot_width_px);
    if (widths.size() < 40) return false;
    const double limit = ratio * median(widths);
    const std::vector<double> arc = path.arc_lengths_px();
    const int n = static_cast<int>(arc.size());
    // Number of points at an end up to the last window of 15 px that is too wide; windows may begin late,
    // since a needle's point is thin.
    const auto needle = [&](bool front) {
        const auto at = [&](int i) { return static_cast<std::size_t>(front ? i : n - 1 - i); };
        int cut = 0;
        for (int i = 0; i < n / 2; ++i) {
            double sum = 0.0;
            int count = 0, k = i;
            for (; k < n && std::abs(arc[at(k)] - arc[at(i)]) <= 15.0; ++k)
                if (edges[at(k)].foot_width_px > 0.0) {
                    sum += edges[at(k)].foot_width_px;
                    ++count;
                }
            if (count >= 5 && sum > limit * count)
                cut = (i + k) / 2;
            else if (std::abs(arc[at(i)] - arc[at(cut)]) > (cut > 0 ? 15.0 : 30.0))
                break;
        }
        return cut;
    };
    const int front = needle(true), back = needle(false);
    if (front + back == 0 || front + back >= n - 20) return false;
    path.points = {path.points.begin() + front, path.points.end() - back};
    edges = {edges.begin() + front, edges.end() - back};
    return true;
}

void centre_between_edges(ImagePath& path, const std::vector<LineEdges>& edges) {
    std::vector<double> widths;
    for (const LineEdges& e : edges)
        if (e.found) widths.push_back(e.width_px());
    const double usual = median(widths);
    const int n = static_cast<int>(path.points.size());
    const auto usable = [&](int i) {
        const LineEdges& e = edges[static_cast<std::size_t>(i)];
        return e.found && e.width_px() < 1.6 * usual && std::abs(e.middle_px()) < std::max(1.0, 0.5 * usual);
    };
    std::vector<Eigen::Vector2d> moved;
    for (int i = 0; i < n; ++i) {
        const RidgePoint& here = path.points[static_cast<std::size_t>(i)];
        const Eigen::Vector2d normal(-here.tangent.y(), here.tangent.x());
        double offset = 0.0;
        int count = 0;
        for (int k = std::max(0, i - 2); k <= std::min(n - 1, i + 2); ++k) {
            if (!usable(k)) continue;
            offset += edges[static_cast<std::size_t>(k)].middle_px();
            ++count;
        }
        moved.push_back(here.px + (count > 0 ? offset / count : 0.0) * normal);
    }
    for (int i = 0; i < n; ++i)
        path.points[static_cast<std::size_t>(i)].px = moved[static_cast<std::size_t>(i)];
}

}  // namespace atropos::tracker
