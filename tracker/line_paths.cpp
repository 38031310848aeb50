#include "tracker/line_paths.hpp"

#include <algorithm>
#include <utility>

namespace atropos::tracker {
namespace {

using Eigen::Vector2d;

bool near_border(const ImageView& image, const Vector2d& px) {
    constexpr double kMargin_px = 6.0;
    return px.minCoeff() < kMargin_px || px.x() > image.width - 1 - kMargin_px ||
           px.y() > image.height - 1 - kMargin_px;
}

/// What a path has beyond the end of a part of it: the other eye's image may end before this one's.
void add_tail(const ImagePath& whole, ImagePath& part) {
    constexpr double kNear_px = 5.0;
    const Vector2d from = part.points.back().px;
    const auto nearest = std::min_element(
        whole.points.begin(), whole.points.end(), [&](const RidgePoint& a, const RidgePoint& b) {
            return (a.px - from).squaredNorm() < (b.px - from).squaredNorm();
        });
    if ((nearest->px - from).norm() < kNear_px)
        part.points.insert(part.points.end(), nearest + 1, whole.points.end());
}

}  // namespace

void write_paths(std::span<const LineNode> line, const std::array<LineEnd, 2>& ends,
                 const std::array<EyeLines, 2>& eyes, std::array<ImagePath, 2>& paths) {
    for (const std::size_t eye : {0, 1}) {
        const std::vector<double> arc = paths[eye].arc_lengths_px();
        ImagePath path;
        path.joins = paths[eye].joins;
        for (std::size_t k = 0; k < line.size(); ++k) {
            const double to = line[k].arc_px[eye], from = k > 0 ? line[k - 1].arc_px[eye] : -1.0;
            if (to < 0.0 || from < 0.0) {
                path.points.push_back(line[k].eye[eye]);
                continue;
            }
            for (auto i = std::upper_bound(arc.begin(), arc.end(), from) - arc.begin();
                 i < std::ssize(arc) && arc[static_cast<std::size_t>(i)] <= to; ++i)
                path.points.push_back(paths[eye].points[static_cast<std::size_t>(i)]);
        }
        for (const std::size_t end : {1, 0}) {
            const LineNode& last = end == 1 ? line.back() : line.front();
            if (ends[end] == LineEnd::kLeaves && !near_border(eyes[eye].image, last.eye[eye].px))
                add_tail(paths[eye], path);
            path.reverse();
            paths[eye].reverse();
        }
        paths[eye] = std::move(path);
    }
}

}  // namespace atropos::tracker
