#include "tracker/thread_initialiser.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "tracker/label_set.hpp"
#include "tracker/stereo_cost_images.hpp"

namespace atropos::tracker {
namespace {

constexpr double kReferenceWidth_px = 640.0;
constexpr double kMinimumSupport = 0.5;  // of the samples, for a curve to count as found
constexpr double kSupport_px = 2.0;      // at 640

struct Level {
    double truncation_px;  ///< of the distance transform, at 640
    double spacing_px;     ///< of the labels, at 640
    int iterations;
};
constexpr Level kLevels[] = {
    {120.0, 12.0, 6}, {60.0, 6.0, 4}, {30.0, 4.0, 4}, {15.0, 2.0, 4}, {15.0, 1.0, 4}};

constexpr int kBulgeAngles = 48;
constexpr double kBulgeTruncation_px = 30.0;  // of the distances by which bulges are compared, at 640
constexpr std::size_t kBulgeFirstLevel =
    2;  // a good bulge is near: the far-reaching labels would only lose it

/// Sag over u of a thread that leaves its ends freely, and of one held in the direction of the chord.
double free_sag(double u) {
    return 4.0 * u * (1.0 - u);
}
double held_sag(double u) {
    return 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * u);
}

double length_m(const CurveSampling& sampling, std::span<const Eigen::Vector3d> curve) {
    double length = 0.0;
    for (int j = 0; j < sampling.samples(); ++j) length += sampling.du() * sampling.velocity(curve, j).norm();
    return length;
}

/// The straight line bent sideways along `direction` until it has the wanted length.
std::vector<Eigen::Vector3d> bulge(const CurveSampling& sampling, const std::vector<Eigen::Vector3d>& line,
                                   const Eigen::Vector3d& direction, double (*sag)(double), double wanted_m) {
    const Eigen::Vector3d chord = line.back() - line.front();
    std::vector<Eigen::Vector3d> curve = line;
    double low_m = 0.0, high_m = wanted_m;
    for (int i = 0; i < 30; ++i) {
        const double height_m = 0.5 * (low_m + high_m);
        for (std::size_t k = 0; k < line.size(); ++k) {
            const double u = (line[k] - line.front()).dot(chord) / chord.squaredNorm();
            curve[k] = line[k] + height_m * sag(u) * direction;
        }
        (length_m(sampling, curve) < wanted_m ? low_m : high_m) = height_m;
    }
    return curve;
}

}  // namespace

std::vector<Eigen::Vector3d> straight_line(int degree, int control_points, const Eigen::Vector3d& from,
                                           const Eigen::Vector3d& to) {
    const BsplineBasis basis(degree, control_points);
    std::vector<Eigen::Vector3d> points;
    for (int k = 0; k < control_points; ++k) {
        double abscissa = 0.0;  // Greville's: control points there give C(u) = from + u (to - from)
        for (int i = 1; i <= degree; ++i) abscissa += basis.knots()[static_cast<std::size_t>(k + i)] / degree;
        points.emplace_back(from + abscissa * (to - from));
    }
    return points;
}

std::optional<std::vector<Eigen::Vector3d>> initial_curve_between_tips(const scenes::TrackerConfig& config,
                                                                       const scenes::StereoRig& rig,
                                                                       const StereoFrame& frame,
                                                                       scenes::WorkerPool& pool) {
    if (!frame.tips[0] || !frame.tips[1]) return std::nullopt;
    const Eigen::Vector3d& from = frame.tips[0]->p_C;
    const Eigen::Vector3d& to = frame.tips[1]->p_C;
    const int K = config.curve.control_points;
    const double depth_m = 0.5 * (from.z() + to.z());
    const double px_scale = kReferenceWidth_px / rig.left.width_px;
    const std::array<Eye, 2> eyes = make_eyes(rig);
    const CurveSampling sampling(config.curve.degree, K, config.curve.samples);
    const std::vector<double> sigmas_px = ridge_scales_px(config, 1.0 / rig.m_per_px(depth_m));
    scenes::TrackerConfig::Labels labels = config.labels;
    labels.shape = scenes::LabelShape::kRays;
    DiscreteSearch search(scenes::TrackerMethod::kE2, config.optimiser, labels, K);

    std::vector<double> speed_m(static_cast<std::size_t>(config.curve.samples));
    std::vector<int> labelling(static_cast<std::size_t>(K));
    StageTimings timings;
    const auto context = [&](const StereoCostImages& images) {
        return EnergyContext{sampling,
                             eyes,
                             images.costs(),
                             speed_m,
                             frame.tips,
                             {.px_scale = px_scale,
                              .length = config.lambda1_e2,
                              .tip_epsilon_m = config.tips.epsilon_m,
                              .tip_per_m = config.tips.weight_per_m}};
    };
    const auto make_images = [&](double truncation_at_640_px) {
        const int truncation_px = std::clamp(static_cast<int>(truncation_at_640_px / px_scale), 1,
                                             DistanceTransform::kMaxTruncation);
        StereoCostImages images(config, sigmas_px, truncation_px);
        images.make(frame, pool);
        return images;
    };

    // Coarse to fine from `curve`; the share of it that is seen in the end.
    const auto descend = [&](std::vector<Eigen::Vector3d>& curve, std::size_t first_level) {
        double seen = 0.0;
        for (std::size_t l = first_level; l < std::size(kLevels); ++l) {
            const Level& level = kLevels[l];
            const StereoCostImages images = make_images(level.truncation_px);
            for (int iteration = 0; iteration < level.iterations; ++iteration) {
                // Of unknown length: whatever it is now, at even speed.
                const double wanted_m =
                    config.thread.length_m > 0.0 ? config.thread.length_m : length_m(sampling, curve);
                std::fill(speed_m.begin(), speed_m.end(), std::max(wanted_m, 1e-6));
                const EnergyContext now = context(images);
                const double s_m = level.spacing_px / px_scale * rig.m_per_px(depth_m) / (1 + iteration % 2);
                search.place_labels(curve, s_m, eyes);
                search.minimise(now, pool, curve, labelling, timings);
                seen = support(now, curve, kSupport_px);
            }
        }
        return seen;
    };

    const std::vector<Eigen::Vector3d> line = straight_line(config.curve.degree, K, from, to);
    std::vector<Eigen::Vector3d> best = line;
    double best_seen = descend(best, 0);
    if (config.thread.length_m > (to - from).norm()) {
        // A slack thread bulges to some side by an amount that its length tells: the side is looked for.
        const StereoCostImages images = make_images(kBulgeTruncation_px);
        std::fill(speed_m.begin(), speed_m.end(), config.thread.length_m);
        const Eigen::Vector3d along = (to - from).normalized(), across = along.unitOrthogonal();
        double least = std::numeric_limits<double>::infinity();
        std::vector<Eigen::Vector3d> bulged;
        for (int i = 0; i < kBulgeAngles; ++i)
            for (const auto sag : {free_sag, held_sag}) {
                const double angle = 2.0 * std::numbers::pi * i / kBulgeAngles;
                const Eigen::Vector3d direction = Eigen::AngleAxisd(angle, along) * across;
                std::vector<Eigen::Vector3d> candidate =
                    bulge(sampling, line, direction, sag, config.thread.length_m);
                const double data = energy(context(images), candidate).data;
                if (data >= least) continue;
                least = data;
                bulged = std::move(candidate);
            }
        const double seen = bulged.empty() ? 0.0 : descend(bulged, kBulgeFirstLevel);
        if (seen > best_seen) {
            best_seen = seen;
            best = std::move(bulged);
        }
    }
    if (best_seen < kMinimumSupport) return std::nullopt;
    return best;
}

}  // namespace atropos::tracker
