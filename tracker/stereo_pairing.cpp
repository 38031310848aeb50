#include "tracker/stereo_pairing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace atropos::tracker {

RectifiedView::RectifiedView(const scenes::StereoRig& rig)
    : rig_(rig),
      rectification_(rig.rectification()),
      focal_px_(rig.left.fx_px),
      baseline_m_(rig.baseline_m()) {}

RectifiedPath RectifiedView::path(const ImagePath& path, int eye, double step_px) const {
    const std::vector<double> arc = path.arc_lengths_px();
    RectifiedPath rectified;
    const int count = std::max(2, static_cast<int>(arc.back() / step_px) + 1);
    std::size_t i = 0;
    for (int k = 0; k < count; ++k) {
        const double s = arc.back() * k / (count - 1);
        while (i + 2 < arc.size() && arc[i + 1] < s) ++i;
        const double share = std::clamp((s - arc[i]) / std::max(arc[i + 1] - arc[i], 1e-9), 0.0, 1.0);
        const Eigen::Vector2d px = (1.0 - share) * path.points[i].px + share * path.points[i + 1].px;
        rectified.points.push_back(this->rectified(px, eye));
        rectified.arc_px.push_back(s);
    }
    return rectified;
}

Eigen::Vector2d RectifiedView::rectified(const Eigen::Vector2d& px, int eye) const {
    const Eigen::Vector2d n = (eye == 0 ? rig_.left : rig_.right).normalised(px);
    const Eigen::Matrix3d& R = eye == 0 ? rectification_.R1 : rectification_.R2;
    const Eigen::Vector3d ray = R * Eigen::Vector3d(n.x(), n.y(), 1.0);
    return focal_px_ * ray.head<2>() / ray.z();
}

Eigen::Vector2d RectifiedView::pixel(const Eigen::Vector2d& rectified, int eye) const {
    const Eigen::Matrix3d& R = eye == 0 ? rectification_.R1 : rectification_.R2;
    const Eigen::Vector3d ray = R.transpose() * Eigen::Vector3d(rectified.x(), rectified.y(), focal_px_);
    return (eye == 0 ? rig_.left : rig_.right).project(ray);
}

Eigen::Vector3d RectifiedView::point(const Eigen::Vector2d& left, double disparity_px) const {
    const Eigen::Vector3d ray(left.x() / focal_px_, left.y() / focal_px_, 1.0);
    return rectification_.R1.transpose() * (depth_m(disparity_px) * ray);
}

scenes::StereoRig RectifiedView::with_row_offset(double rows_px) const {
    scenes::StereoRig rig = rig_;
    // About x, towards +y: what lies ahead is seen further down.
    const Eigen::AngleAxisd turn(-std::atan(rows_px / focal_px_), Eigen::Vector3d::UnitX());
    rig.X_RC = Eigen::Isometry3d(Eigen::Quaterniond(rectification_.R2.transpose() * turn.toRotationMatrix() *
                                                    rectification_.R2)) *
               rig_.X_RC;
    return rig;
}

Pairing pair_paths(const RectifiedView& view, const RectifiedPath& left, const RectifiedPath& right,
                   double row_offset_px, bool right_turned, const PairingOptions& options) {
    constexpr float kNever = std::numeric_limits<float>::max();
    const int n = static_cast<int>(left.points.size()), m = static_cast<int>(right.points.size());
    const double step_left = left.arc_px[1], step_right = right.arc_px[1];
    // No strand is seen more than 2.5 times as long by one eye as by the other.
    const int most = std::max(1, static_cast<int>(std::ceil(2.5 * step_left / step_right)));
    const float least_disparity = static_cast<float>(view.disparity_px(options.farthest_m));
    const float most_disparity = static_cast<float>(view.disparity_px(options.nearest_m));
    const float inverse_sigma = static_cast<float>(1.0 / options.row_sigma_px);
    const float truncation = static_cast<float>(std::pow(options.largest_row_px / options.row_sigma_px, 2));
    const float slope = static_cast<float>(options.slope_cost_per_px);
    const float skip_left = static_cast<float>(options.skip_cost_per_px * step_left);
    const float skip_right = static_cast<float>(options.skip_cost_per_px * step_right);

    std::vector<float> x(static_cast<std::size_t>(m)), y(x.size());
    for (int j = 0; j < m; ++j) {
        const Eigen::Vector2d& p = right.points[static_cast<std::size_t>(right_turned ? m - 1 - j : j)];
        x[static_cast<std::size_t>(j)] = static_cast<float>(p.x());
        y[static_cast<std::size_t>(j)] = static_cast<float>(p.y() - row_offset_px);
    }
    std::vector<float> before(x.size(), kNever), now(x.size());
    std::vector<std::int16_t> from(static_cast<std::size_t>(n) * x.size(), -1);
    float best = kNever;
    int best_i = -1, best_j = -1;
    for (int i = 0; i < n; ++i) {
        const Eigen::Vector2f p = left.points[static_cast<std::size_t>(i)].cast<float>();
        const float moved =
            i == 0 ? 0.0f : p.x() - static_cast<float>(left.points[static_cast<std::size_t>(i - 1)].x());
        for (int j = 0; j < m; ++j) {
            const std::size_t jj = static_cast<std::size_t>(j);
            now[jj] = kNever;
            const float disparity = p.x() - x[jj];
            if (disparity < least_disparity || disparity > most_disparity) continue;
            const float row = std::abs(p.y() - y[jj]);
            if (row > 12.0f) continue;
            float least = skip_left * static_cast<float>(i) + skip_right * static_cast<float>(j);
            std::int16_t source = -1;
            for (int k = std::max(0, j - most); i > 0 && k <= j; ++k) {
                const std::size_t kk = static_cast<std::size_t>(k);
                if (before[kk] == kNever) continue;
                const float cost = before[kk] + slope * std::abs(moved - (x[jj] - x[kk]));
                if (cost < least) {
                    least = cost;
                    source = static_cast<std::int16_t>(k);
                }
            }
            const float r = row * inverse_sigma;
            now[jj] = least + std::min(r * r, truncation);
            from[static_cast<std::size_t>(i) * x.size() + jj] = source;
            const float whole = now[jj] + skip_left * static_cast<float>(n - 1 - i) +
                                skip_right * static_cast<float>(m - 1 - j);
            if (whole < best) {
                best = whole;
                best_i = i;
                best_j = j;
            }
        }
        std::swap(before, now);
    }

    Pairing pairing;
    pairing.right.assign(static_cast<std::size_t>(n), -1);
    pairing.cost = std::numeric_limits<double>::infinity();
    if (best_i < 0) return pairing;
    pairing.cost = static_cast<double>(best);
    const auto forwards = [&](int j) { return right_turned ? m - 1 - j : j; };
    int pairs = 0, first_j = best_j;
    for (int i = best_i, j = best_j; j >= 0; --i) {
        pairing.right[static_cast<std::size_t>(i)] = forwards(j);
        pairing.mean_row_px +=
            std::min(options.largest_row_px, std::abs(left.points[static_cast<std::size_t>(i)].y() -
                                                      static_cast<double>(y[static_cast<std::size_t>(j)])));
        ++pairs;
        first_j = j;
        j = from[static_cast<std::size_t>(i) * x.size() + static_cast<std::size_t>(j)];
    }
    pairing.mean_row_px /= pairs;
    pairing.right_begin = std::min(forwards(first_j), forwards(best_j));
    pairing.right_end = std::max(forwards(first_j), forwards(best_j)) + 1;
    return pairing;
}

}  // namespace atropos::tracker
