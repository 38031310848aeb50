#include "tests/support/background.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "scenes/polyline.hpp"
#include "scenes/random_stream.hpp"

namespace atropos::support {
namespace {

/// Smooth noise on the wall: random values on a lattice, blended by a cubic; mean 0, about unit amplitude.
class LatticeNoise {
  public:
    explicit LatticeNoise(scenes::RandomStream& random) {
        for (float& v : values_) v = static_cast<float>(random.uniform(-1.0, 1.0));
    }
    double at(double x, double y) const {
        const double fx = std::floor(x);
        const double fy = std::floor(y);
        const double tx = smooth(x - fx);
        const double ty = smooth(y - fy);
        const int ix = static_cast<int>(fx);
        const int iy = static_cast<int>(fy);
        const double top = value(ix, iy) * (1.0 - tx) + value(ix + 1, iy) * tx;
        const double low = value(ix, iy + 1) * (1.0 - tx) + value(ix + 1, iy + 1) * tx;
        return top * (1.0 - ty) + low * ty;
    }

  private:
    static constexpr int kSize = 64;
    static double smooth(double t) { return t * t * (3.0 - 2.0 * t); }
    double value(int x, int y) const {
        return values_[static_cast<std::size_t>(((y % kSize + kSize) % kSize) * kSize +
                                                (x % kSize + kSize) % kSize)];
    }
    std::array<float, kSize * kSize> values_{};
};

struct PaintedLine {
    std::vector<Eigen::Vector2d> points;  ///< on the wall, m
    double width_m;
    double level;                  ///< grey levels added; negative = dark
    Eigen::AlignedBox2d box = {};  ///< all that it changes lies within

    double reach_m() const { return 3.0 * width_m; }
};

double distance_to(const PaintedLine& line, const Eigen::Vector2d& p) {
    double best = 1e9;
    for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
        const Eigen::Vector2d a = line.points[i];
        const Eigen::Vector2d d = line.points[i + 1] - a;
        const double t = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
        best = std::min(best, (p - a - t * d).norm());
    }
    return best;
}

PaintedLine random_line(scenes::RandomStream& random, double reach_m, double width_m, double level) {
    PaintedLine line{{}, width_m, level};
    Eigen::Vector2d p(random.uniform(-reach_m, reach_m), random.uniform(-reach_m, reach_m));
    double heading = random.uniform(0.0, 2.0 * std::numbers::pi);
    const double bend = random.uniform(-0.25, 0.25);
    for (int i = 0; i < 24; ++i) {
        line.points.push_back(p);
        heading += bend + random.normal(0.0, 0.12);
        p += reach_m / 14.0 * Eigen::Vector2d(std::cos(heading), std::sin(heading));
    }
    for (const Eigen::Vector2d& point : line.points)
        for (const double side : {-line.reach_m(), line.reach_m()})
            line.box.extend(Eigen::Vector2d(point.array() + side));
    return line;
}

/// Coverage of a box of the line's width after a soft edge of `blur_m`.
double soft_box(double distance, double half_width, double blur) {
    const double k = 1.0 / (std::numbers::sqrt2 * blur);
    return 0.5 * (std::erf((half_width - distance) * k) + std::erf((half_width + distance) * k));
}

}  // namespace

std::pair<cv::Mat1f, cv::Mat1f> paint_background(const scenes::StereoRig& rig,
                                                 const BackgroundOptions& options) {
    scenes::RandomStream random(options.seed, "background");
    const LatticeNoise noise(random);
    std::vector<PaintedLine> lines;
    const double size = options.feature_m;
    for (int i = 0; i < options.vessels; ++i)
        lines.push_back(random_line(random, 0.7 * size, options.vessel_width_m * random.uniform(0.8, 2.0),
                                    -options.vessel_contrast * random.uniform(0.4, 1.2)));
    for (int i = 0; i < 4; ++i)  // folds: broad and faint
        lines.push_back(random_line(random, 0.8 * size, 0.05 * size * random.uniform(0.5, 1.5),
                                    random.uniform(-25.0, 25.0)));

    const Eigen::Vector3d normal = Eigen::Vector3d(-options.slope_x, -options.slope_y, 1.0);
    const auto paint = [&](const scenes::Camera& camera, const Eigen::Isometry3d& X_CE) {
        cv::Mat1f image(camera.height_px, camera.width_px);
        for (int v = 0; v < camera.height_px; ++v)
            for (int u = 0; u < camera.width_px; ++u) {
                const Eigen::Vector3d ray = X_CE.linear() * camera.ray({u, v});
                const double along = (options.depth_m - normal.dot(X_CE.translation())) / normal.dot(ray);
                const Eigen::Vector3d p = X_CE.translation() + along * ray;
                double level = options.mean_level;
                if (options.clutter) {
                    for (int octave = 0; octave < 5; ++octave) {
                        const double f = std::exp2(octave) * 4.0 / size;
                        level += 16.0 / (1.0 + octave) * noise.at(f * p.x() + 7.3 * octave, f * p.y());
                    }
                    level += 300.0 * (p.x() + 0.5 * p.y()) * (0.07 / size);
                    for (const PaintedLine& line : lines) {
                        if (!line.box.contains(p.head<2>())) continue;
                        const double d = distance_to(line, p.head<2>());
                        if (d < line.reach_m())
                            level += line.level * soft_box(d, 0.5 * line.width_m, 0.25 * line.width_m);
                    }
                }
                image(v, u) = static_cast<float>(level);
            }
        return image;
    };
    std::pair<cv::Mat1f, cv::Mat1f> eyes{paint(rig.left, Eigen::Isometry3d::Identity()),
                                         paint(rig.right, rig.X_RC.inverse())};
    const int spots = options.clutter ? 25 : 0;
    for (cv::Mat1f* image : {&eyes.first, &eyes.second})
        for (int i = 0; i < spots; ++i) {
            const double x = random.uniform(0.0, image->cols);
            const double y = random.uniform(0.0, image->rows);
            const double rx = random.uniform(1.0, 5.0) * image->cols / 640.0;
            const double ry = random.uniform(1.0, 5.0) * image->cols / 640.0;
            for (int v = std::max(0, int(y - 3 * ry)); v < std::min(image->rows, int(y + 3 * ry)); ++v)
                for (int u = std::max(0, int(x - 3 * rx)); u < std::min(image->cols, int(x + 3 * rx)); ++u) {
                    const double q = std::pow((u - x) / rx, 2) + std::pow((v - y) / ry, 2);
                    const double share = 1.0 / (1.0 + std::exp(4.0 * (q - 1.0)));
                    (*image)(v, u) += static_cast<float>(share * (245.0 - (*image)(v, u)));
                }
        }
    return eyes;
}

}  // namespace atropos::support
