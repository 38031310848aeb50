#include "tracker/thread_initialiser.hpp"

#include <algorithm>
#include <cmath>

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
                                                                       WorkerPool& pool) {
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

    std::vector<Eigen::Vector3d> curve = straight_line(config.curve.degree, K, from, to);
    std::vector<double> speed_m(static_cast<std::size_t>(config.curve.samples));
    std::vector<int> labelling(static_cast<std::size_t>(K));
    StageTimings timings;
    double seen = 0.0;
    const cv::Rect whole({}, frame.left.size());
    for (const Level& level : kLevels) {
        const int truncation_px =
            std::clamp(static_cast<int>(level.truncation_px / px_scale), 1, DistanceTransform::kMaxTruncation);
        StereoCostImages images(config, sigmas_px, truncation_px);
        images.make(frame, {whole, whole}, pool);
        for (int iteration = 0; iteration < level.iterations; ++iteration) {
            double length_m = config.thread.length_m;
            if (length_m <= 0.0)  // unknown: whatever it is now, at even speed
                for (int j = 0; j < sampling.samples(); ++j)
                    length_m += sampling.du() * sampling.velocity(curve, j).norm();
            std::fill(speed_m.begin(), speed_m.end(), std::max(length_m, 1e-6));
            const EnergyContext context{sampling,
                                        eyes,
                                        images.costs(),
                                        speed_m,
                                        frame.tips,
                                        {.px_scale = px_scale,
                                         .length = config.lambda1_e2,
                                         .tip_epsilon_m = config.tips.epsilon_m,
                                         .tip_per_m = config.tips.weight_per_m}};
            const double s_m = level.spacing_px / px_scale * rig.m_per_px(depth_m) / (1 + iteration % 2);
            search.step(context, s_m, pool, curve, labelling, timings);
            seen = support(context, curve, kSupport_px);
        }
    }
    if (seen < kMinimumSupport) return std::nullopt;
    return curve;
}

}  // namespace atropos::tracker
