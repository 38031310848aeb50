#include "experiments/instrument_outline.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace atropos::experiments {
using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
namespace {

constexpr double kSlice_m = 0.003;
constexpr double kShaftShown_m = 0.030;  // of the shaft, from the wrist
constexpr int kDirections = 160;
constexpr double kNearest_m = 0.01;  // to the camera

/// Points of one link by slice along z; edges that cross a boundary give a point to both slices.
std::vector<std::vector<Vector3d>> slices(const std::vector<render::MeshPart>& parts) {
    double low = 1e9, high = -1e9;
    const auto clipped = [](const Eigen::Vector3f& v) {
        Vector3d p = v.cast<double>();
        p.z() = std::max(p.z(), -kShaftShown_m);
        return p;
    };
    for (const render::MeshPart& part : parts)
        for (const Eigen::Vector3f& v : part.mesh->vertices) {
            low = std::min(low, clipped(v).z());
            high = std::max(high, clipped(v).z());
        }
    if (!(high > low)) return {};
    const int count = std::max(1, static_cast<int>(std::lround((high - low) / kSlice_m)));
    const double step = (high - low) / count;
    std::vector<std::vector<Vector3d>> points(static_cast<size_t>(count));
    const auto slice_of = [&](double z) {
        return std::clamp(static_cast<int>((z - low) / step), 0, count - 1);
    };
    for (const render::MeshPart& part : parts)
        for (const auto& triangle : part.mesh->triangles)
            for (size_t corner = 0; corner < 3; ++corner) {
                Vector3d a = clipped(part.mesh->vertices[triangle[corner]]);
                Vector3d b = clipped(part.mesh->vertices[triangle[(corner + 1) % 3]]);
                if (a.z() > b.z()) std::swap(a, b);
                const int from = slice_of(a.z()), to = slice_of(b.z());
                points[static_cast<size_t>(from)].push_back(a);
                points[static_cast<size_t>(to)].push_back(b);
                for (int i = from; i < to; ++i) {
                    const double share = (low + (i + 1) * step - a.z()) / (b.z() - a.z());
                    const Vector3d p = a + share * (b - a);
                    points[static_cast<size_t>(i)].push_back(p);
                    points[static_cast<size_t>(i) + 1].push_back(p);
                }
            }
    return points;
}

/// Those points that are farthest in some of many directions (a Fibonacci sphere).
Eigen::Matrix3Xd extreme(std::vector<Vector3d> points) {
    // Each vertex comes once for each of its edges.
    const auto before = [](const Vector3d& a, const Vector3d& b) {
        return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
    };
    std::sort(points.begin(), points.end(), before);
    points.erase(std::unique(points.begin(), points.end()), points.end());
    std::vector<size_t> chosen;
    for (int i = 0; i < kDirections; ++i) {
        const double z = 1.0 - (2.0 * i + 1.0) / kDirections,
                     angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
        const double r = std::sqrt(1.0 - z * z);
        const Vector3d direction(r * std::cos(angle), r * std::sin(angle), z);
        size_t best = 0;
        for (size_t k = 1; k < points.size(); ++k)
            if (direction.dot(points[k]) > direction.dot(points[best])) best = k;
        chosen.push_back(best);
    }
    std::sort(chosen.begin(), chosen.end());
    chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
    Eigen::Matrix3Xd result(3, static_cast<Eigen::Index>(chosen.size()));
    for (size_t k = 0; k < chosen.size(); ++k) result.col(static_cast<Eigen::Index>(k)) = points[chosen[k]];
    return result;
}

}  // namespace

InstrumentOutline::InstrumentOutline(const render::InstrumentModel& model) {
    for (int link = 0; link < robot::kLinkCount; ++link)
        for (const auto& points : slices(model.links[static_cast<size_t>(link)]))
            if (points.size() >= 4) pieces_.push_back({link, extreme(points)});
}

std::vector<InstrumentOutline::Polygon> InstrumentOutline::project(
    const scenes::Camera& camera, std::span<const Isometry3d, robot::kLinkCount> X_EL) const {
    std::vector<Polygon> polygons;
    std::vector<cv::Point2f> seen;
    std::vector<int> hull;
    for (const Piece& piece : pieces_) {
        const Isometry3d& X = X_EL[static_cast<size_t>(piece.link)];
        seen.clear();
        for (Eigen::Index k = 0; k < piece.points.cols(); ++k) {
            const Vector3d p_E = X * piece.points.col(k);
            if (p_E.z() < kNearest_m) break;
            const Vector2d px = camera.project(p_E);
            seen.emplace_back(static_cast<float>(px.x()), static_cast<float>(px.y()));
        }
        if (static_cast<Eigen::Index>(seen.size()) < piece.points.cols()) continue;
        cv::convexHull(seen, hull, true);
        Polygon polygon;
        polygon.link = piece.link;
        for (const int k : hull) {
            const cv::Point2f& px = seen[static_cast<size_t>(k)];
            polygon.px.emplace_back(px.x, px.y);
            polygon.p_L.emplace_back(piece.points.col(k));
        }
        polygons.push_back(std::move(polygon));
    }
    return polygons;
}

void InstrumentOutline::move(const scenes::Camera& camera,
                             std::span<const Isometry3d, robot::kLinkCount> X_EL,
                             std::vector<Polygon>& polygons) {
    for (Polygon& polygon : polygons)
        for (size_t k = 0; k < polygon.px.size(); ++k) {
            const Vector3d p_E = X_EL[static_cast<size_t>(polygon.link)] * polygon.p_L[k];
            if (p_E.z() >= kNearest_m) polygon.px[k] = camera.project(p_E);
        }
}

void paint(const std::vector<InstrumentOutline::Polygon>& polygons, int value, cv::Mat& mask) {
    constexpr int kShift = 4;
    std::vector<cv::Point> corners;
    for (const auto& polygon : polygons) {
        corners.clear();
        for (const Vector2d& px : polygon.px)
            corners.emplace_back(static_cast<int>(std::lround(px.x() * (1 << kShift))),
                                 static_cast<int>(std::lround(px.y() * (1 << kShift))));
        cv::fillConvexPoly(mask, corners, cv::Scalar(value), cv::LINE_8, kShift);
    }
}

}  // namespace atropos::experiments
