#include "tracker/instrument_offset.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tracker/capsule_silhouette.hpp"
#include "tracker/normal_profile.hpp"
#include "tracker/occlusion_mask.hpp"

namespace atropos::tracker {
namespace {

using Vector4d = Eigen::Vector4d;  // offset in C (m) and widening (m)

/// One point of the outline: how its place along the normal moves, and the edges found there.
struct OutlinePoint {
    Eigen::RowVector4d px_per_m;  ///< offset along the normal (px) by shift in C and by widening
    int half = 0;
    float step_px = 1.0f;
    std::array<float, 2 * NormalProfile::kMaxHalf + 1> edge{};  ///< strength in [0, 1], by offset

    std::array<float, 2 * NormalProfile::kMaxHalf + 1> near_edge{};  ///< the same, falling off over some px

    /// Of either at an offset (px), 0 where nothing was read.
    float at(const std::array<float, 2 * NormalProfile::kMaxHalf + 1>& values, double offset_px) const {
        const float place = static_cast<float>(offset_px) / step_px + static_cast<float>(half);
        const int i = static_cast<int>(std::floor(place));
        if (place < 0.0f || i + 1 > 2 * half) return 0.0f;
        const float share = place - static_cast<float>(i);
        return (1.0f - share) * values[static_cast<std::size_t>(i)] +
               share * values[static_cast<std::size_t>(i + 1)];
    }

    /// So that a coarse search does not step over an edge.
    void spread(double reach_px) {
        const int reach = static_cast<int>(std::ceil(reach_px / static_cast<double>(step_px)));
        for (int i = 0; i <= 2 * half; ++i)
            for (int j = std::max(0, i - reach); j <= std::min(2 * half, i + reach); ++j) {
                const float fall = 1.0f - static_cast<float>(std::abs(i - j)) / static_cast<float>(reach + 1);
                auto& value = near_edge[static_cast<std::size_t>(i)];
                value = std::max(value, fall * edge[static_cast<std::size_t>(j)]);
            }
    }
};

void collect(const StereoFrame& frame, const scenes::StereoRig& rig, bool right,
             std::span<const scenes::Capsule> instrument_C, std::span<const scenes::Capsule> others_C,
             const InstrumentOffsetOptions& options, std::vector<OutlinePoint>& points) {
    const scenes::Camera& camera = right ? rig.right : rig.left;
    const Eigen::Isometry3d X_EC = right ? rig.X_RC : Eigen::Isometry3d::Identity();
    const double scale = camera.width_px / 640.0;
    std::vector<scenes::Capsule> capsules(instrument_C.begin(), instrument_C.end());
    for (scenes::Capsule& capsule : capsules) {
        capsule.a = X_EC * capsule.a;
        capsule.b = X_EC * capsule.b;
    }
    cv::Mat buffer;
    const ImageView image = channel_view(right ? frame.right : frame.left, options.channel, buffer);
    const OcclusionMask mask(others_C, X_EC.inverse().translation(), 0.001, 0.0);
    NormalProfile profile;
    for (const SilhouettePoint& outline : capsule_silhouette(capsules, camera, 3.0 * scale)) {
        if (mask.hides(X_EC.inverse() * outline.p)) continue;
        OutlinePoint point;
        const Eigen::RowVector3d by_shift = outline.normal.transpose() * outline.px_per_m;
        point.px_per_m.head<3>() = by_shift * X_EC.linear();
        point.px_per_m[3] = camera.fx_px / outline.p.z();
        const double reach_px = (3.5 * options.prior_sigma_m) * camera.fx_px / outline.p.z();
        const double step = std::max(1.0, reach_px / (NormalProfile::kMaxHalf - 4));
        const NormalLine line{outline.px, outline.normal, {-outline.normal.y(), outline.normal.x()}};
        profile.read(image, line, step, static_cast<int>(reach_px / step) + 2, 5, std::max(1.0, scale));
        point.half = profile.half;
        point.step_px = static_cast<float>(step);
        const int wide = std::max(1, static_cast<int>(std::lround(scale / step)));
        for (int i = profile.first + wide; i <= profile.last - wide; ++i) {
            const float slope = std::abs(profile[i + wide] - profile[i - wide]);
            const float strength = slope / (slope + static_cast<float>(options.edge_levels));
            point.edge[static_cast<std::size_t>(i + profile.half)] = strength;
        }
        point.spread(3.5 * scale);
        points.push_back(point);
    }
}

double score(const std::vector<OutlinePoint>& points, const Vector4d& x, const Vector4d& sigma, bool coarse) {
    double sum = 0.0;
    for (const OutlinePoint& point : points)
        sum += static_cast<double>(point.at(coarse ? point.near_edge : point.edge, point.px_per_m * x));
    return sum / static_cast<double>(points.size()) - 0.01 * x.cwiseQuotient(sigma).squaredNorm();
}

/// The best of a grid of shifts, coarse then fine: lateral steps of a pixel or two, longer ones in depth.
Vector4d search(const std::vector<OutlinePoint>& points, const Vector4d& sigma) {
    Vector4d best = Vector4d::Zero();
    Vector4d step(0.5, 0.5, 1.0, 0.0);
    step.head<3>() *= sigma[0] / 1.5;
    Eigen::Vector4i reach(8, 8, 4, 0);
    for (int level = 0; level < 4; ++level) {
        const bool coarse = level < 2;
        const Vector4d centre = best;
        double best_score = score(points, centre, sigma, coarse);
        for (int i = -reach[0]; i <= reach[0]; ++i)
            for (int j = -reach[1]; j <= reach[1]; ++j)
                for (int k = -reach[2]; k <= reach[2]; ++k)
                    for (int w = -reach[3]; w <= reach[3]; ++w) {
                        const Vector4d x = centre + Vector4d(i, j, k, w).cwiseProduct(step);
                        const double s = score(points, x, sigma, coarse);
                        if (s > best_score) {
                            best_score = s;
                            best = x;
                        }
                    }
        step *= 0.5;
        step[3] = 0.5 * sigma[3] / (1.0 + level);
        reach = {2, 2, 2, 1};
    }
    return best;
}

/// Offset of the strongest edge near `offset_px`, sub-pixel; false when there is none.
bool nearest_edge(const OutlinePoint& point, double offset_px, double search_px, double& edge_px) {
    const int centre =
        static_cast<int>(std::lround(offset_px / static_cast<double>(point.step_px))) + point.half;
    const int reach =
        std::max(1, static_cast<int>(std::lround(search_px / static_cast<double>(point.step_px))));
    const int from = std::max(1, centre - reach);
    const int to = std::min(2 * point.half - 1, centre + reach);
    double best = 0.15;
    bool found = false;
    for (int i = from; i <= to; ++i) {
        const double a = static_cast<double>(point.edge[static_cast<std::size_t>(i - 1)]);
        const double b = static_cast<double>(point.edge[static_cast<std::size_t>(i)]);
        const double c = static_cast<double>(point.edge[static_cast<std::size_t>(i + 1)]);
        if (b < a || b <= c || b < best) continue;
        best = b;
        found = true;
        const double bend = a - 2.0 * b + c;
        edge_px =
            (i - point.half + (bend < 0.0 ? 0.5 * (a - c) / bend : 0.0)) * static_cast<double>(point.step_px);
    }
    return found;
}

}  // namespace

InstrumentOffset find_instrument_offset(const StereoFrame& frame, const scenes::StereoRig& rig,
                                        std::span<const scenes::Capsule> instrument_C,
                                        std::span<const scenes::Capsule> others_C,
                                        const InstrumentOffsetOptions& options) {
    check_frame(frame, rig);
    InstrumentOffset result;
    std::vector<OutlinePoint> points;
    collect(frame, rig, false, instrument_C, others_C, options, points);
    collect(frame, rig, true, instrument_C, others_C, options, points);
    if (points.size() < 30) return result;

    const Vector4d sigma(options.prior_sigma_m, options.prior_sigma_m, options.prior_sigma_m,
                         options.shape_sigma_m);
    Vector4d x = search(points, sigma);
    const double scale = rig.left.width_px / 640.0;
    Eigen::Matrix4d H;
    double squares = 0.0, supported = 0.0;
    double sigma_px = scale;
    for (const double search_px : {5.0, 3.0, 2.0, 2.0, 2.0}) {
        H = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
        Vector4d g = -H * x;
        squares = supported = 0.0;
        for (const OutlinePoint& point : points) {
            const double here_px = point.px_per_m * x;
            double edge_px = 0.0;
            if (!nearest_edge(point, here_px, search_px * scale, edge_px)) continue;
            const double r = edge_px - here_px;
            const double weight = 1.0 / (1.0 + r * r / (scale * scale));
            // Neighbours on the outline err together: texture and shape, not noise. Each counts a 20th.
            const double information = 0.05 * weight / (sigma_px * sigma_px);
            H += information * point.px_per_m.transpose() * point.px_per_m;
            g += information * r * point.px_per_m.transpose();
            squares += weight * r * r;
            supported += weight;
        }
        x += H.ldlt().solve(g);
        sigma_px = std::sqrt((squares + scale * scale) / (supported + 1.0));
    }
    result.offset_C = x.head<3>();
    result.wider_m = x[3];
    // What all of the outline may be wrong by at once is in no residual.
    const double common_m = 0.5 * options.shape_sigma_m;
    result.covariance = H.inverse().topLeftCorner<3, 3>() + common_m * common_m * Eigen::Matrix3d::Identity();
    result.support = supported / static_cast<double>(points.size());
    result.found = result.support >= options.least_support && x.allFinite();
    return result;
}

}  // namespace atropos::tracker
