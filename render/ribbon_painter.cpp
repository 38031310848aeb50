#include "render/ribbon_painter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/ribbon_strip.hpp"

namespace atropos::render {
namespace {

constexpr double kReach_sigma = 4.0;  // beyond it less than 4e-5 of the light is left

// What one thread's band adds to one pixel.
struct Fragment {
    int pixel;      // row-major index
    int strip;      // which part of which thread
    double arc_px;  // where along that part
    float depth_m;  // of the axis
    float radius_m;
    float alpha;            // share of the pixel's light
    Eigen::Vector3f light;  // R G B, alpha included
};

// Standard normal distribution.
inline double normal_cdf(double x) {
    return 0.5 * std::erfc(-x * (1.0 / std::numbers::sqrt2));
}

class BandPainter {
  public:
    BandPainter(int width_px, int height_px, double sigma_px, std::vector<Fragment>& out)
        : width_px_(width_px), height_px_(height_px), sigma_px_(sigma_px), out_(out) {}

    void paint(const std::vector<RibbonVertex>& vertices, int strip, double radius_m) {
        for (std::size_t i = 0; i + 1 < vertices.size(); ++i) {
            paint_segment(vertices, i, strip, radius_m);
        }
    }

  private:
    void paint_segment(const std::vector<RibbonVertex>& vertices, std::size_t i, int strip, double radius_m) {
        const RibbonVertex &a = vertices[i], &b = vertices[i + 1];
        const bool is_first = i == 0, is_last = i + 2 == vertices.size();
        const double reach = std::max(a.half_width_px, b.half_width_px) + kReach_sigma * sigma_px_;
        const double x0 = std::min(a.pixel.x(), b.pixel.x()) - reach,
                     x1 = std::max(a.pixel.x(), b.pixel.x()) + reach;
        const double y0 = std::min(a.pixel.y(), b.pixel.y()) - reach,
                     y1 = std::max(a.pixel.y(), b.pixel.y()) + reach;
        if (!(x1 >= 0.0 && y1 >= 0.0 && x0 <= width_px_ - 1.0 && y0 <= height_px_ - 1.0)) return;
        const int left = static_cast<int>(std::max(0.0, std::ceil(x0)));
        const int right = static_cast<int>(std::min(width_px_ - 1.0, std::floor(x1)));
        const int top = static_cast<int>(std::max(0.0, std::ceil(y0)));
        const int bottom = static_cast<int>(std::min(height_px_ - 1.0, std::floor(y1)));
        for (int y = top; y <= bottom; ++y) {
            for (int x = left; x <= right; ++x) {
                const Eigen::Vector2d p(x, y);
                // Neighbouring segments share the line through their vertex: each pixel is in one of them.
                const double from_a = (p - a.pixel).dot(a.along), to_b = (b.pixel - p).dot(b.along);
                if ((from_a < 0.0 && !is_first) || (to_b <= 0.0 && !is_last)) continue;
                const double along = from_a + to_b;
                const double t = along > 0.0 ? std::clamp(from_a / along, 0.0, 1.0) : 0.5;
                const Eigen::Vector2d direction = b.pixel - a.pixel;
                const Eigen::Vector2d d = p - (a.pixel + t * direction);
                const Eigen::Vector2d on_end = (1.0 - t) * a.along + t * b.along;
                double lateral = on_end.x() * d.y() - on_end.y() * d.x();
                if (t > 0.0 && t < 1.0) lateral = std::copysign(d.norm(), lateral);
                if (std::abs(lateral) > reach) continue;
                const double cap = end_share(p, vertices);
                if (cap > 1e-6) add(p, a, b, t, lateral, cap, strip, radius_m);
            }
        }
    }

    // The lens blurs the two cut ends as well.
    double end_share(const Eigen::Vector2d& p, const std::vector<RibbonVertex>& vertices) const {
        const RibbonVertex &first = vertices.front(), &last = vertices.back();
        const double near = kReach_sigma * sigma_px_ + 2.0 * first.half_width_px + 2.0;
        double share = 1.0;
        if ((p - first.pixel).squaredNorm() < near * near) share *= step((p - first.pixel).dot(first.along));
        if ((p - last.pixel).squaredNorm() < near * near) share *= step((last.pixel - p).dot(last.along));
        return share;
    }

    double step(double x_px) const {
        return sigma_px_ > 0.0 ? normal_cdf(x_px / sigma_px_) : (x_px >= 0.0 ? 1.0 : 0.0);
    }

    void add(const Eigen::Vector2d& p, const RibbonVertex& a, const RibbonVertex& b, double t, double lateral,
             double cap, int strip, double radius_m) {
        const double half = a.half_width_px + t * (b.half_width_px - a.half_width_px);
        Eigen::Vector3f light = Eigen::Vector3f::Zero();
        double below = step(-half - lateral);
        const double all_below = below;
        for (int k = 0; k < kStrips; ++k) {
            const double edge = half * (2.0 * (k + 1) / kStrips - 1.0);
            const double next = step(edge - lateral);
            const auto i = static_cast<std::size_t>(k);
            const auto share = static_cast<float>((next - below) * cap), u = static_cast<float>(t);
            light += share * (a.radiance[i] + u * (b.radiance[i] - a.radiance[i]));
            below = next;
        }
        const auto alpha = static_cast<float>((below - all_below) * cap);
        if (alpha < 1e-6f) return;
        const int pixel = static_cast<int>(p.y()) * width_px_ + static_cast<int>(p.x());
        out_.push_back({pixel, strip, a.arc_px + t * (b.arc_px - a.arc_px),
                        static_cast<float>(a.depth_m + t * (b.depth_m - a.depth_m)),
                        static_cast<float>(radius_m), alpha, light});
    }

    int width_px_, height_px_;
    double sigma_px_;
    std::vector<Fragment>& out_;
};

// Share of the pixel's samples where the scene doesn't hide a thread at this depth; its own radius is let
// off, so that a thread on the tissue isn't cut by the slope beside it.
float seen_share(const EyeSamples& scene, const Fragment& f) {
    const int s = scene.supersampling, x = f.pixel % scene.width_px * s, y = f.pixel / scene.width_px * s;
    const float nearest = f.depth_m - 2.0f * f.radius_m;
    const auto is_seen = [&](int dx, int dy) {
        const float depth = scene.depth_m(x + dx, y + dy);
        return depth == 0.0f || depth > nearest ? 1.0f : 0.0f;
    };
    if (s == 1) return is_seen(0, 0);
    return 0.25f * is_seen(0, 0) +
           0.125f * (is_seen(-1, 0) + is_seen(1, 0) + is_seen(0, -1) + is_seen(0, 1)) +
           0.0625f * (is_seen(-1, -1) + is_seen(1, -1) + is_seen(-1, 1) + is_seen(1, 1));
}

// Pixels inside a bend lie in the band of several segments: of one pass only the nearest part counts.
void keep_one_per_pass(std::vector<Fragment>& fragments, double pass_px) {
    std::sort(fragments.begin(), fragments.end(), [](const Fragment& a, const Fragment& b) {
        return std::tie(a.pixel, a.strip, a.arc_px) < std::tie(b.pixel, b.strip, b.arc_px);
    });
    std::size_t kept = 0;
    double last_arc_px = 0.0;
    for (const Fragment& f : fragments) {
        const bool same_pass = kept > 0 && fragments[kept - 1].pixel == f.pixel &&
                               fragments[kept - 1].strip == f.strip && f.arc_px - last_arc_px < pass_px;
        last_arc_px = f.arc_px;
        if (!same_pass) {
            fragments[kept++] = f;
        } else if (f.alpha > fragments[kept - 1].alpha) {
            fragments[kept - 1] = f;
        }
    }
    fragments.resize(kept);
}

}  // namespace

void paint_ribbons(std::span<const ThreadRibbon> ribbons, const Eye& eye, const Eigen::Isometry3d& X_EW,
                   const EyeLight& light, const EyeSamples& scene, double sigma_px, cv::Mat& linear,
                   cv::Mat& coverage) {
    std::vector<Fragment> fragments;
    BandPainter painter(scene.width_px, scene.height_px, sigma_px, fragments);
    int strip = 0;
    double widest_px = 0.0;
    for (const ThreadRibbon& ribbon : ribbons) {
        for (const auto& vertices : ribbon_strips(ribbon, eye, X_EW, light)) {
            painter.paint(vertices, strip++, ribbon.radius_m);
            for (const RibbonVertex& v : vertices) widest_px = std::max(widest_px, v.half_width_px);
        }
    }
    keep_one_per_pass(fragments, 3.0 * (widest_px + 3.0 * sigma_px));
    std::sort(fragments.begin(), fragments.end(), [](const Fragment& a, const Fragment& b) {
        return std::tie(a.pixel, b.depth_m, a.strip, a.arc_px) <
               std::tie(b.pixel, a.depth_m, b.strip, b.arc_px);
    });
    for (const Fragment& f : fragments) {
        const float seen = seen_share(scene, f), alpha = seen * f.alpha;
        float* out = linear.ptr<float>() + 3 * f.pixel;
        for (int c = 0; c < 3; ++c) out[c] = out[c] * (1.0f - alpha) + seen * f.light[2 - c];
        float& covered = coverage.ptr<float>()[f.pixel];
        covered += alpha * (1.0f - covered);
    }
}

}  // namespace atropos::render
