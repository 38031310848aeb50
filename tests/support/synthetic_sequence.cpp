#include "tests/support/synthetic_sequence.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/random_stream.hpp"
#include "tracker/nurbs_curve.hpp"

namespace atropos::support {
namespace {

constexpr int kFilmSize = 1 << 21;  // noise values, read from another place in every frame

/// Point and width of a drawn line in an image, px.
struct Stroke {
    Eigen::Vector2d p;
    double half_width;
    double level;
};

/// Draws thick strokes over `image`: each pixel takes the nearest stroke's level by its soft coverage.
void draw_strokes(cv::Mat1f& image, const std::vector<Stroke>& strokes, double blur_px, bool relative) {
    cv::Rect2d around;
    for (const Stroke& stroke : strokes) {
        const double reach = stroke.half_width + 3.5 * blur_px + 1.0;
        const cv::Rect2d box(stroke.p.x() - reach, stroke.p.y() - reach, 2.0 * reach, 2.0 * reach);
        around = around.empty() ? box : around | box;
    }
    const cv::Rect2d inside = around & cv::Rect2d(0.0, 0.0, image.cols, image.rows);
    if (inside.empty()) return;
    const cv::Rect region = cv::Rect(cv::Point(inside.tl()), cv::Point(inside.br()) + cv::Point(1, 1)) &
                            cv::Rect({}, image.size());
    cv::Mat1f depth(region.size(), -1e9f);  // how deep inside the nearest stroke a pixel lies
    cv::Mat1f coverage(region.size(), 0.0f);
    cv::Mat1f level(region.size(), 0.0f);
    const double k = 1.0 / (std::numbers::sqrt2 * blur_px);
    for (std::size_t i = 0; i + 1 < strokes.size(); ++i) {
        const Stroke& a = strokes[i];
        const Stroke& b = strokes[i + 1];
        const Eigen::Vector2d d = b.p - a.p;
        const double reach = std::max(a.half_width, b.half_width) + 3.5 * blur_px;
        const int u0 = std::max(region.x, static_cast<int>(std::floor(std::min(a.p.x(), b.p.x()) - reach)));
        const int u1 =
            std::min(region.br().x - 1, static_cast<int>(std::ceil(std::max(a.p.x(), b.p.x()) + reach)));
        const int v0 = std::max(region.y, static_cast<int>(std::floor(std::min(a.p.y(), b.p.y()) - reach)));
        const int v1 =
            std::min(region.br().y - 1, static_cast<int>(std::ceil(std::max(a.p.y(), b.p.y()) + reach)));
        for (int v = v0; v <= v1; ++v)
            for (int u = u0; u <= u1; ++u) {
                const Eigen::Vector2d p(u, v);
                const double t = std::clamp((p - a.p).dot(d) / std::max(d.squaredNorm(), 1e-12), 0.0, 1.0);
                const double distance = (p - a.p - t * d).norm();
                const double half = a.half_width + t * (b.half_width - a.half_width);
                float& deepest = depth(v - region.y, u - region.x);
                if (half - distance <= deepest) continue;
                deepest = static_cast<float>(half - distance);
                coverage(v - region.y, u - region.x) = static_cast<float>(
                    0.5 * (std::erf((half - distance) * k) + std::erf((half + distance) * k)));
                level(v - region.y, u - region.x) = static_cast<float>(a.level + t * (b.level - a.level));
            }
    }
    for (int v = 0; v < region.height; ++v)
        for (int u = 0; u < region.width; ++u) {
            float& pixel = image(v + region.y, u + region.x);
            const float share = coverage(v, u);
            if (share > 0.0f) pixel += share * (relative ? level(v, u) : level(v, u) - pixel);
        }
}

constexpr double kMostPaidOut = 1.15;  ///< of the length at first

double length_at(const SyntheticSequenceOptions& options, int original) {
    return std::min(options.length_m + options.paid_out_m * original, kMostPaidOut * options.length_m);
}

scenes::Polyline first_part(const scenes::Polyline& line, double length_m) {
    scenes::Polyline part;
    const std::size_t n = line.points.size();
    for (std::size_t i = 0; i < n; ++i)
        part.points.push_back(line.point_at(length_m * static_cast<double>(i) / static_cast<double>(n - 1)));
    return part;
}

}  // namespace

InextensibleCurveOptions curve_options(const SyntheticSequenceOptions& options) {
    scenes::RandomStream random(options.seed, "synthetic sequence");
    InextensibleCurveOptions curve;
    curve.seed = options.seed;
    curve.length_m = (options.paid_out_m > 0.0 ? kMostPaidOut : 1.0) * options.length_m;
    curve.centre_C = {0.5 * options.rig.X_RC.inverse().translation().x(), 0.0, options.depth_m};
    curve.heading_rad = random.uniform(0.45, 1.0) * (random.uniform() < 0.5 ? 1.0 : -1.0);
    curve.turning_rad = random.uniform(1.2, 2.2) * (random.uniform() < 0.5 ? 1.0 : -1.0);
    curve.depth_tilt_rad = random.uniform(-0.25, 0.25);
    curve.arc_tilt_rad = random.uniform(-0.5, 0.5);
    curve.heading_rad = options.heading_rad.value_or(curve.heading_rad);
    curve.turning_rad = options.turning_rad.value_or(curve.turning_rad);
    curve.arc_tilt_rad = options.arc_tilt_rad.value_or(curve.arc_tilt_rad);
    curve.turning_share = options.turning_share;
    curve.turning_swing_rad = options.turning_swing_rad;
    curve.travel_share = options.travel_share;
    const double px_m = options.depth_m / options.rig.left.fx_px;
    curve.speed_m_per_frame = 0.45 * px_m * options.motion_scale;
    return curve;
}

SyntheticSequence::SyntheticSequence(const SyntheticSequenceOptions& options)
    : options_(options), thread_(options) {
    BackgroundOptions wall;
    wall.seed = options.seed;
    wall.depth_m = options.depth_m + 0.3 * options.length_m;
    wall.clutter = options.clutter;
    wall.feature_m = options.length_m;
    wall.vessel_width_m = options.width_m * wall.depth_m / options.depth_m;
    wall.mean_level = options.dark ? 150.0 : 90.0;
    std::tie(background_[0], background_[1]) = paint_background(options.rig, wall);

    scenes::RandomStream film(options.seed, "sensor noise");
    noise_.resize(kFilmSize);
    for (float& value : noise_) value = static_cast<float>(film.normal(0.0, options.noise_levels));
    scenes::RandomStream random(options.seed, "tip errors");
    for (Eigen::Vector3d& error : tip_error_)
        error = options.tip_error_m * random.uniform(0.33, 1.0) *
                Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
}

SyntheticThread::SyntheticThread(const SyntheticSequenceOptions& options)
    : options_(options), curve_(curve_options(options)) {}

scenes::Polyline SyntheticThread::truth(int index) const {
    const int original = index * options_.acceleration;
    scenes::Polyline line = curve_.at(original);
    if (options_.paid_out_m > 0.0) line = first_part(line, length_at(options_, original));
    if (options_.protocol == Protocol::kS) return line;
    // Jitter of a tracked template: small in every frame, large in some (Table I: 8 px at acceleration 1).
    tracker::NurbsCurve spline = tracker::fit_curve(line, {.control_points = 8, .length_weight = 0.3});
    std::vector<Eigen::Vector3d> points = spline.control_points();
    scenes::RandomStream random(scenes::derive_seed(options_.seed, static_cast<std::uint64_t>(original)),
                                "jitter");
    const double px_m = options_.depth_m / options_.rig.left.fx_px;
    for (Eigen::Vector3d& q : points)
        q += 0.42 * px_m * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    const bool leap = original % 60 == 30 || original % 60 == 0;
    if (leap && random.uniform() < 0.25) {
        const std::size_t k = 1 + random.integer(6);
        const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
        points[k] +=
            random.uniform(10.5, 12.5) * px_m * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
    }
    spline.set_control_points(points);
    return tracker::sampled(spline, 401);
}

std::vector<scenes::Capsule> SyntheticSequence::shafts(const scenes::Polyline& thread, int index) const {
    std::vector<scenes::Capsule> shafts;
    if (options_.instruments)
        for (int end = 0; end < 2; ++end) {
            if (end == 1 && options_.free_end) continue;
            if (options_.jaws) {
                shafts.push_back(jaw(thread, end));
                continue;
            }
            const double L = thread.length_m();
            const Eigen::Vector3d tip = thread.point_at(end == 0 ? 0.0 : L);
            const Eigen::Vector3d inner =
                thread.point_at(end == 0 ? options_.hidden_end_m : L - options_.hidden_end_m);
            const Eigen::Vector3d centre = thread.point_at(0.5 * L);
            Eigen::Vector3d away = tip - centre;
            away.z() = -0.3 * away.norm();  // towards the camera, as shafts come
            away.normalize();
            shafts.push_back({inner - 0.0005 * Eigen::Vector3d::UnitZ(), inner + 0.15 * away, 0.0016});
        }
    const int since = index - options_.occlusion_begin;
    if (options_.occlusion_begin >= 0 && since >= 0 && since < options_.occlusion_frames) {
        const double L = thread.length_m();
        const Eigen::Vector3d hidden = thread.point_at(0.5 * L);
        const Eigen::Vector3d along = (thread.point_at(0.6 * L) - thread.point_at(0.4 * L)).normalized();
        Eigen::Vector3d across = along.cross(Eigen::Vector3d::UnitZ()).normalized();
        across.z() = -0.3;
        across.normalize();
        const Eigen::Vector3d before = hidden - 0.1 * options_.depth_m * Eigen::Vector3d::UnitZ();
        shafts.push_back({before - 0.01 * across, before + 0.1 * across, 0.45 * options_.occluded_share * L});
    }
    return shafts;
}

/// Closed jaws that hold the thread some mm before their tip, and the shaft behind them.
scenes::Capsule SyntheticSequence::jaw(const scenes::Polyline& thread, int end) const {
    const double L = thread.length_m();
    const Eigen::Vector3d grip = thread.point_at(end == 0 ? 0.0 : L);
    const Eigen::Vector3d outwards = (grip - thread.point_at(end == 0 ? 0.003 : L - 0.003)).normalized();
    Eigen::Vector3d distal = outwards.cross(Eigen::Vector3d::UnitZ()).normalized();
    if (distal.y() < 0.0) distal = -distal;
    distal += (end == 0 ? 0.3 : -0.5) * outwards;
    distal.z() = 0.3;  // from the camera's side
    distal.normalize();
    const Eigen::Vector3d before = grip - 0.0008 * Eigen::Vector3d::UnitZ();
    return {before + 0.002 * distal, before - 0.15 * distal, 0.0013};
}

/// The thread goes straight on beyond its grips, sagging a little.
scenes::Polyline SyntheticSequence::with_tails(const scenes::Polyline& thread) const {
    if (!(options_.tail_m > 0.0)) return thread;
    const double L = thread.length_m();
    const auto tail = [&](double from, double inner) {
        const Eigen::Vector3d grip = thread.point_at(from);
        const Eigen::Vector3d outwards = (grip - thread.point_at(inner)).normalized();
        std::vector<Eigen::Vector3d> points;
        for (int i = 1; i <= 40; ++i) {
            const double s = options_.tail_m * i / 40.0;
            points.push_back(grip + s * outwards + 20.0 * s * s * Eigen::Vector3d::UnitY());
        }
        return points;
    };
    scenes::Polyline all;
    all.points = tail(0.0, 0.001);
    std::reverse(all.points.begin(), all.points.end());
    all.points.insert(all.points.end(), thread.points.begin(), thread.points.end());
    const std::vector<Eigen::Vector3d> after = tail(L, L - 0.001);
    all.points.insert(all.points.end(), after.begin(), after.end());
    return all;
}

cv::Mat1b SyntheticSequence::draw(int eye, int index, const scenes::Polyline& thread,
                                  const std::vector<scenes::Capsule>& shafts) const {
    const scenes::Camera& camera = eye == 0 ? options_.rig.left : options_.rig.right;
    const Eigen::Isometry3d X_EC = eye == 0 ? Eigen::Isometry3d::Identity() : options_.rig.X_RC;
    cv::Mat1f image = background_[static_cast<std::size_t>(eye)].clone();

    std::vector<Stroke> strokes;
    const std::vector<double> s = thread.arc_lengths_m();
    for (std::size_t i = 0; i < thread.points.size(); i += 2) {
        const Eigen::Vector3d p = X_EC * thread.points[i];
        if (p.z() < 0.01) continue;
        const double wobble = 1.0 + 0.2 * std::sin(900.0 * s[i] + static_cast<double>(options_.seed));
        strokes.push_back({camera.project(p), 0.5 * options_.width_m * camera.fx_px / p.z(),
                           (options_.dark ? -1.0 : 1.0) * options_.contrast * wobble});
    }
    draw_strokes(image, strokes, options_.blur_px, true);

    for (const scenes::Capsule& shaft : shafts) {
        std::vector<Stroke> body;
        std::vector<Stroke> streak;
        for (int i = 0; i <= 60; ++i) {
            const Eigen::Vector3d p = X_EC * (shaft.a + i / 60.0 * (shaft.b - shaft.a));
            if (p.z() < 0.02) break;
            const double half = shaft.radius_m * camera.fx_px / p.z();
            body.push_back({camera.project(p), half, 70.0});
            streak.push_back({camera.project(p) - Eigen::Vector2d(0.0, 0.35 * half), 0.2 * half, 200.0});
        }
        draw_strokes(image, body, options_.blur_px, false);
        draw_strokes(image, streak, 1.5 * options_.blur_px, false);
    }

    scenes::RandomStream random(
        scenes::derive_seed(options_.seed,
                            static_cast<std::uint64_t>(2 * index * options_.acceleration + eye)),
        "film");
    std::uint64_t cursor = random.integer(kFilmSize);
    cv::Mat1b out(image.size());
    for (int v = 0; v < image.rows; ++v)
        for (int u = 0; u < image.cols; ++u) {
            const float value = image(v, u) + noise_[cursor];
            cursor = (cursor + 1) & (kFilmSize - 1);
            out(v, u) = static_cast<unsigned char>(std::clamp(value, 0.0f, 255.0f) + 0.5f);
        }
    return out;
}

SyntheticFrame SyntheticSequence::frame(int index) const {
    SyntheticFrame frame;
    frame.time_s = index * options_.acceleration / 30.0;
    frame.truth_C = truth(index);
    const scenes::Polyline drawn = with_tails(frame.truth_C);
    frame.instruments_C = shafts(frame.truth_C, index);
    std::vector<scenes::Capsule> seen = frame.instruments_C;
    if (options_.jaws)
        for (std::size_t end = 0; end < 2 && options_.instruments; ++end) {
            const Eigen::Vector3d aside = options_.jaw_excess_m * 0.4 * Eigen::Vector3d::UnitX();
            seen[end] = {seen[end].a + aside, seen[end].b + aside,
                         seen[end].radius_m + options_.jaw_excess_m};
        }
    frame.left = draw(0, index, drawn, seen);
    frame.right = draw(1, index, drawn, seen);

    scenes::RandomStream random(scenes::derive_seed(options_.seed, static_cast<std::uint64_t>(index)),
                                "tip jitter");
    for (std::size_t end = 0; end < 2; ++end) {
        const Eigen::Vector3d error =
            tip_error_[end] +
            options_.tip_jitter_m * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
        frame.tips_C[end] = (end == 0 ? frame.truth_C.points.front() : frame.truth_C.points.back()) + error;
        if (!options_.instruments) continue;
        frame.instruments_C[end].a += error;
        frame.instruments_C[end].b += error;
    }
    return frame;
}

}  // namespace atropos::support
