#include "tracker/cut_check.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "tracker/occlusion_mask.hpp"
#include "tracker/valley_association.hpp"
#include "tracker/valley_filter.hpp"

namespace atropos::tracker {
namespace {

constexpr double kStep_m = 0.0002;
constexpr double kBehind_m = 0.002;
constexpr double kLeastContrast = 0.4;  // of the thread's usual one in this frame

struct Place {
    double s_m;
    Eigen::Vector3d p_C;
    Eigen::Vector3d tangent;
};

/// What one eye sees across one place.
struct Sight {
    bool visible = false;
    bool valley = false;
    double offset_px = 0.0;
    double depth_levels = 0.0;
    Eigen::RowVector3d px_per_m = Eigen::RowVector3d::Zero();  ///< offset by a displacement in C
};

std::vector<Place> places_around(const scenes::ThreadEstimate& estimate, double s_m, double reach_m) {
    scenes::Polyline line;
    for (const scenes::ThreadSample& sample : estimate.samples) line.points.push_back(sample.p_C);
    const double length_m = line.length_m();
    std::vector<Place> places;
    for (double s = std::max(0.0, s_m - reach_m); s <= std::min(length_m, s_m + reach_m); s += kStep_m) {
        const Eigen::Vector3d along = line.point_at(s + 0.0005) - line.point_at(s - 0.0005);
        if (along.norm() > 0.0) places.push_back({s, line.point_at(s), along.normalized()});
    }
    return places;
}

std::vector<Sight> look(const StereoFrame& frame, const scenes::StereoRig& rig, bool right,
                        const std::vector<Place>& places, const CutCheckOptions& options) {
    const scenes::Camera& camera = right ? rig.right : rig.left;
    const Eigen::Isometry3d X_EC = right ? rig.X_RC : Eigen::Isometry3d::Identity();
    const OcclusionMask mask(frame.instruments, X_EC.inverse().translation(),
                             2.0 * options.instrument_sigma_m, kBehind_m);
    cv::Mat buffer;
    const ImageView image = channel_view(right ? frame.right : frame.left, options.channel, buffer);
    const ValleyFilter filter({.polarity = options.polarity, .threshold_levels = options.contrast_levels});
    std::vector<Sight> sights(places.size());
    std::vector<ValleyCandidates> candidates(places.size());
    double search_px = 4.0;
    for (std::size_t j = 0; j < places.size(); ++j) {
        const Eigen::Vector3d p = X_EC * places[j].p_C;
        if (p.z() < 0.005) continue;
        Eigen::Matrix<double, 2, 3> J_px;
        NormalLine line;
        line.p_px = camera.project(p, J_px);
        const Eigen::Matrix<double, 2, 3> J_C = J_px * X_EC.linear();
        const Eigen::Vector2d along = J_C * places[j].tangent;
        if (!camera.contains(line.p_px) || along.norm() < 0.15 * camera.fx_px / p.z()) continue;
        if (mask.hides(places[j].p_C)) continue;
        line.tangent = along.normalized();
        line.normal = {-line.tangent.y(), line.tangent.x()};
        sights[j].visible = true;
        sights[j].px_per_m = line.normal.transpose() * J_C;
        search_px = options.search_m * camera.fx_px / p.z();
        candidates[j].count = filter.find(image, line, search_px, options.width_m * camera.fx_px / p.z(),
                                          candidates[j].valleys);
    }
    ValleyAssociation association;
    const std::span<const int> chosen =
        association.choose(candidates, options.contrast_levels, {.search_px = search_px, .jump_px = 0.7});
    for (std::size_t j = 0; j < places.size(); ++j) {
        if (chosen[j] < 0) continue;
        const Valley& valley = candidates[j].valleys[static_cast<std::size_t>(chosen[j])];
        sights[j].valley = true;
        sights[j].offset_px = valley.offset_px;
        sights[j].depth_levels = valley.depth_levels;
    }
    return sights;
}

/// Whether one displacement across the thread, no longer than it can have moved, explains both offsets.
bool agree(const Sight& left, const Sight& right, const Place& place, double search_m) {
    const Eigen::Vector3d across = place.tangent.unitOrthogonal();
    Eigen::Matrix<double, 3, 2> plane;
    plane << across, place.tangent.cross(across);
    Eigen::Matrix2d A;
    A.row(0) = left.px_per_m * plane;
    A.row(1) = right.px_per_m * plane;
    const Eigen::Vector2d offsets(left.offset_px, right.offset_px);
    // Weighted: half a pixel of measurement against the way it can have gone, three times as far in depth.
    const double sigma_m = 3.0 * search_m;
    const Eigen::Matrix2d H = 4.0 * A.transpose() * A + Eigen::Matrix2d::Identity() / (sigma_m * sigma_m);
    const Eigen::Vector2d moved = H.ldlt().solve(4.0 * A.transpose() * offsets);
    return (A * moved - offsets).norm() < 1.5 && moved.norm() < 2.0 * sigma_m;
}

/// The thread's own contrast: of the best quarter of what lies away from the place.
double usual_contrast(const std::vector<Place>& places, const std::vector<Sight>& left,
                      const std::vector<Sight>& right, double s_m, double near_m) {
    std::vector<double> depths;
    for (std::size_t j = 0; j < places.size(); ++j)
        if (std::abs(places[j].s_m - s_m) > near_m && left[j].valley && right[j].valley)
            depths.push_back(std::min(left[j].depth_levels, right[j].depth_levels));
    if (depths.empty()) return 0.0;
    const auto upper = depths.begin() + static_cast<std::ptrdiff_t>(3 * depths.size() / 4);
    std::nth_element(depths.begin(), upper, depths.end());
    return *upper;
}

}  // namespace

const char* to_string(CutVerdict verdict) {
    switch (verdict) {
        case CutVerdict::kIntact:
            return "intact";
        case CutVerdict::kCut:
            return "cut";
        case CutVerdict::kUnknown:
            break;
    }
    return "unknown";
}

CutCheck check_cut(const StereoFrame& frame, const scenes::StereoRig& rig,
                   const scenes::ThreadEstimate& estimate, double s_m, const CutCheckOptions& options) {
    check_frame(frame, rig);
    CutCheck check;
    const std::vector<Place> places = places_around(estimate, s_m, options.reach_m);
    if (places.empty()) return check;
    const std::vector<Sight> left = look(frame, rig, false, places, options);
    const std::vector<Sight> right = look(frame, rig, true, places, options);

    const double usual = options.usual_levels > 0.0
                             ? options.usual_levels
                             : usual_contrast(places, left, right, s_m, options.near_m);

    struct Count {
        double places = 0.0, visible = 0.0, supported = 0.0;
        double share() const { return visible > 0.0 ? supported / visible : 0.0; }
    } at, before, after;
    for (std::size_t j = 0; j < places.size(); ++j) {
        const double ds = places[j].s_m - s_m;
        Count& count = std::abs(ds) <= options.near_m ? at : ds < 0.0 ? before : after;
        count.places += 1.0;
        if (!left[j].visible || !right[j].visible) continue;
        count.visible += 1.0;
        const bool thread = left[j].valley && right[j].valley &&
                            std::min(left[j].depth_levels, right[j].depth_levels) > kLeastContrast * usual &&
                            agree(left[j], right[j], places[j], options.search_m);
        count.supported += thread;
    }
    check.visible = at.places > 0.0 ? at.visible / at.places : 0.0;
    check.support_at = at.share();
    check.support_before = before.share();
    check.support_after = after.share();
    check.usual_levels = usual;
    if (check.visible < options.least_visible) return check;
    const auto goes_on = [&](const Count& side) {
        return side.visible == 0.0 || side.share() >= options.side_support;
    };
    if (check.support_at >= options.intact_support && goes_on(before) && goes_on(after))
        check.verdict = CutVerdict::kIntact;
    if (check.support_at <= options.cut_support) check.verdict = CutVerdict::kCut;
    return check;
}

}  // namespace atropos::tracker
