#include "render/ribbon_strip.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "render/ribbon_shading.hpp"

namespace atropos::render {
namespace {

constexpr double kNearest_m = 1e-3;
constexpr double kStep_px = 0.75;
constexpr int kMostSteps = 4096;  // a segment that crosses the whole image at 1080p

bool is_in_front(const Eigen::Vector3d& p, double r2_max) {
    return p.z() > kNearest_m && p.head<2>().squaredNorm() < r2_max * p.z() * p.z();
}

// Vertices without direction along the image and length, which need neighbours.
RibbonVertex make_vertex(const ThreadRibbon& ribbon, const Eye& eye, const EyeLight& light,
                         const Eigen::Vector3d& p, const Eigen::Vector3d& along, double s_m) {
    Eigen::Matrix<double, 2, 3> J;
    RibbonVertex vertex;
    vertex.pixel = eye.camera.project(p, J);
    vertex.depth_m = p.z();
    Eigen::Vector3d across = along.cross(p);
    if (across.squaredNorm() < 1e-12 * p.squaredNorm()) across = along.unitOrthogonal();
    across.normalize();
    const Eigen::Vector2d along_px = J * along, edge_px = J * (ribbon.radius_m * across);
    vertex.along = along_px.norm() > 1e-9 ? along_px.normalized()
                                          : Eigen::Vector2d(edge_px.y(), -edge_px.x()).normalized();
    vertex.half_width_px = std::abs(vertex.along.x() * edge_px.y() - vertex.along.y() * edge_px.x());
    vertex.radiance = shade_cross_section(ribbon, light, p, along, s_m, along_px.norm());
    return vertex;
}

// Directions from neighbours on the image, so that bands meet on common lines.
void finish(std::vector<RibbonVertex>& strip) {
    std::vector<Eigen::Vector2d> along(strip.size());
    for (std::size_t i = 0; i < strip.size(); ++i) {
        Eigen::Vector2d sum = Eigen::Vector2d::Zero();
        if (i > 0) sum += (strip[i].pixel - strip[i - 1].pixel).normalized();
        if (i + 1 < strip.size()) sum += (strip[i + 1].pixel - strip[i].pixel).normalized();
        along[i] = sum.squaredNorm() > 1e-12 ? sum.normalized() : strip[i].along;
    }
    for (std::size_t i = 0; i < strip.size(); ++i) {
        strip[i].along = along[i];
        strip[i].arc_px = i == 0 ? 0.0 : strip[i - 1].arc_px + (strip[i].pixel - strip[i - 1].pixel).norm();
    }
}

}  // namespace

std::vector<std::vector<RibbonVertex>> ribbon_strips(const ThreadRibbon& ribbon, const Eye& eye,
                                                     const Eigen::Isometry3d& X_EW, const EyeLight& light) {
    std::vector<std::vector<RibbonVertex>> strips;
    std::vector<RibbonVertex> strip;
    const double r2_max = monotonic_r2(eye.camera);
    const auto& points = ribbon.curve_W.points;
    const auto close_strip = [&] {
        if (strip.size() >= 2) {
            finish(strip);
            strips.push_back(std::move(strip));
        }
        strip.clear();
    };
    double s_m = 0.0;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const Eigen::Vector3d a = X_EW * points[i], b = X_EW * points[i + 1];
        const double length_m = (b - a).norm();
        if (length_m < 1e-12) continue;
        if (!is_in_front(a, r2_max) || !is_in_front(b, r2_max)) {
            close_strip();
            s_m += length_m;
            continue;
        }
        const Eigen::Vector3d along = (b - a) / length_m;
        const double length_px = (eye.camera.project(b) - eye.camera.project(a)).norm();
        const int steps = std::clamp(static_cast<int>(std::ceil(length_px / kStep_px)), 1, kMostSteps);
        for (int k = strip.empty() ? 0 : 1; k <= steps; ++k) {
            const double t = static_cast<double>(k) / steps;
            RibbonVertex vertex = make_vertex(ribbon, eye, light, a + t * (b - a), along, s_m + t * length_m);
            if (strip.empty() || (vertex.pixel - strip.back().pixel).norm() > 1e-6) strip.push_back(vertex);
        }
        s_m += length_m;
    }
    close_strip();
    return strips;
}

}  // namespace atropos::render
