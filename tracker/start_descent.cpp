#include "tracker/start_descent.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tracker/label_set.hpp"

namespace atropos::tracker {
namespace {

constexpr double kReferenceWidth_px = 640.0;
constexpr double kSupport_px = 2.0;  // at 640

struct Level {
    double truncation_px;  ///< of the distance transform, at 640
    double spacing_px;     ///< of the labels, at 640
    int iterations;
};
constexpr Level kLevel[StartDescent::kLevels] = {
    {120.0, 12.0, 6}, {60.0, 6.0, 4}, {30.0, 4.0, 4}, {15.0, 2.0, 4}, {15.0, 1.0, 4}};

constexpr int kBulgeAngles = 48;
constexpr double kBulgeTruncation_px = 30.0;  // of the distances by which bulges are compared, at 640

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

scenes::TrackerConfig::Labels along_rays(scenes::TrackerConfig::Labels labels) {
    labels.shape = scenes::LabelShape::kRays;
    return labels;
}

}  // namespace

StartDescent::StartDescent(const scenes::TrackerConfig& config, const scenes::StereoRig& rig,
                           const StereoFrame& frame, std::size_t levels, scenes::WorkerPool& pool)
    : config_(config),
      rig_(rig),
      frame_(frame),
      pool_(pool),
      levels_(std::min(levels, std::size(kLevel))),
      depth_m_(0.5 * (frame.tips[0]->p_C.z() + frame.tips[1]->p_C.z())),
      px_scale_(kReferenceWidth_px / rig.left.width_px),
      eyes_(make_eyes(rig)),
      sampling_(config.curve.degree, config.curve.control_points, config.curve.samples),
      search_(scenes::TrackerMethod::kE2, config.optimiser, along_rays(config.labels),
              config.curve.control_points),
      images_(config, ridge_scales_px(config, 1.0 / rig.m_per_px(depth_m_)), 1),
      speed_m_(static_cast<std::size_t>(config.curve.samples)),
      labelling_(static_cast<std::size_t>(config.curve.control_points)) {
    images_.begin(frame);
}

StartDescent::Found StartDescent::run(std::vector<Eigen::Vector3d> curve, std::size_t first) {
    for (std::size_t l = first; l < levels_; ++l) {
        const Level& level = kLevel[l];
        truncate(level.truncation_px);
        int unmoved = 0;
        // Unmoved by the labels of both spacings, it stays where it is.
        for (int iteration = 0; iteration < level.iterations && unmoved < 2; ++iteration) {
            // Of unknown length: whatever it is now, at even speed.
            const double wanted_m =
                config_.thread.length_m > 0.0 ? config_.thread.length_m : length_m(sampling_, curve);
            std::fill(speed_m_.begin(), speed_m_.end(), std::max(wanted_m, 1e-6));
            const double s_m = level.spacing_px / px_scale_ * rig_.m_per_px(depth_m_) / (1 + iteration % 2);
            search_.place_labels(curve, s_m, eyes_);
            for (std::size_t eye = 0; eye < 2; ++eye)
                for (int j = 0; j < sampling_.samples(); ++j)
                    images_.want(static_cast<int>(eye), search_.reach(context(), eye, curve, j));
            images_.compute(pool_);
            search_.minimise(context(), pool_, curve, labelling_, timings_);
            const bool moved =
                std::any_of(labelling_.begin(), labelling_.end(), [](int label) { return label != 0; });
            unmoved = moved ? 0 : unmoved + 1;
        }
    }
    Found found{std::move(curve)};
    found.seen = support(context(), found.curve, kSupport_px);
    found.energy = energy(context(), found.curve).total;
    return found;
}

std::vector<std::vector<Eigen::Vector3d>> StartDescent::best_bulges(
    const std::vector<Eigen::Vector3d>& line) {
    truncate(kBulgeTruncation_px);
    std::fill(speed_m_.begin(), speed_m_.end(), config_.thread.length_m);
    const Eigen::Vector3d along = (line.back() - line.front()).normalized(), across = along.unitOrthogonal();
    struct Bulge {
        double data = std::numeric_limits<double>::infinity();
        std::vector<Eigen::Vector3d> curve;
    };
    std::vector<std::vector<Eigen::Vector3d>> candidates;
    for (int i = 0; i < kBulgeAngles; ++i)
        for (const auto sag : {free_sag, held_sag}) {
            const double angle = 2.0 * std::numbers::pi * i / kBulgeAngles;
            const Eigen::Vector3d direction = Eigen::AngleAxisd(angle, along) * across;
            candidates.push_back(bulge(sampling_, line, direction, sag, config_.thread.length_m));
            want_along(candidates.back());
        }
    images_.compute(pool_);
    std::vector<Bulge> by_angle(kBulgeAngles);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
        const double data = energy(context(), candidates[i]).data;
        if (data < by_angle[i / 2].data) by_angle[i / 2] = {data, std::move(candidates[i])};
    }
    std::vector<Bulge> sides;
    for (std::size_t i = 0; i < by_angle.size(); ++i) {
        const double before = by_angle[(i + kBulgeAngles - 1) % kBulgeAngles].data,
                     after = by_angle[(i + 1) % kBulgeAngles].data;
        if (by_angle[i].data <= before && by_angle[i].data < after) sides.push_back(by_angle[i]);
    }
    std::sort(sides.begin(), sides.end(), [](const Bulge& a, const Bulge& b) { return a.data < b.data; });
    std::vector<std::vector<Eigen::Vector3d>> best;
    for (std::size_t i = 0; i < std::min<std::size_t>(2, sides.size()); ++i)
        best.push_back(std::move(sides[i].curve));
    return best;
}

EnergyContext StartDescent::context() const {
    return {sampling_,
            eyes_,
            images_.costs(),
            speed_m_,
            frame_.tips,
            {.px_scale = px_scale_,
             .length = config_.lambda1_e2,
             .tip_epsilon_m = config_.tips.epsilon_m,
             .tip_per_m = config_.tips.weight_per_m}};
}

void StartDescent::truncate(double at_640_px) {
    images_.set_truncation(
        std::clamp(static_cast<int>(at_640_px / px_scale_), 1, DistanceTransform::kMaxTruncation));
}

void StartDescent::want_along(std::span<const Eigen::Vector3d> curve) {
    for (std::size_t eye = 0; eye < 2; ++eye)
        for (int j = 0; j < sampling_.samples(); ++j) {
            const Eigen::Vector2d px =
                eyes_[eye].pixel(context().seen(eye, curve, j)).cwiseMax(-1e6).cwiseMin(1e6);
            images_.want(static_cast<int>(eye), {static_cast<int>(std::floor(px.x())) - 1,
                                                 static_cast<int>(std::floor(px.y())) - 1, 4, 4});
        }
}

}  // namespace atropos::tracker
