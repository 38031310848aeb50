#include "tracker/recovery.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tracker/thread_initialiser.hpp"

namespace atropos::tracker {
namespace {

constexpr int kMostWidth_px = 960;     ///< of the pictures searched: larger ones are made smaller
constexpr double kSpacing_m = 0.0012;  ///< of the labels
constexpr int kSamples = 30;           ///< along the curve: what is found is to be refined
constexpr std::size_t kLevels = 4;     ///< of five

constexpr double kJaws_m = 0.012;      ///< most of a thread that jaws hide at an end
constexpr double kLengthError = 0.08;  ///< of a traced thread, its hidden ends cut short
constexpr double kLeastAcross =
    0.5;  ///< of a curve's length: where nothing tells depth, depth hides any length
constexpr int kTracedPoints = 400, kTracedControlPoints = 40;

/// How much of a line in C runs across the viewing rays.
double share_across_view(const scenes::Polyline& line) {
    double across_m = 0.0;
    for (std::size_t i = 1; i < line.points.size(); ++i) {
        const Eigen::Vector3d step = line.points[i] - line.points[i - 1];
        across_m += step.cross(line.points[i].normalized()).norm();
    }
    return across_m / line.length_m();
}

NurbsCurve fitted(const scenes::Polyline& line) {
    return fit_curve(line.resampled(kTracedPoints),
                     {.degree = 3, .control_points = kTracedControlPoints, .length_weight = 0.3});
}

/// Seven control points or eight are few enough for pairs of labels to move every part of the curve.
scenes::TrackerConfig search_config(scenes::TrackerConfig config) {
    config.method = scenes::TrackerMethod::kE2;
    config.optimiser = scenes::LabelOptimiser::kDynamicProgramming;
    config.parameterisation = scenes::Parameterisation::k3d;
    config.thread.length_is_known = config.thread.length_m > 0.0;
    config.curve.control_points = 8;
    config.curve.degree = 3;
    config.curve.samples = kSamples;
    config.labels.shape = scenes::LabelShape::kRays;
    config.labels.preset = scenes::LabelPreset::kCustom;
    config.labels.r = 2;
    config.labels.s_m = kSpacing_m;
    config.lambda1_e2 = 100.0;
    return config;
}

}  // namespace

double shrinkage(const scenes::StereoRig& rig) {
    return rig.left.width_px > kMostWidth_px ? 640.0 / rig.left.width_px : 1.0;
}

Recovery::Recovery(const scenes::TrackerConfig& config, const scenes::StereoRig& rig)
    : config_(search_config(config)),
      shrinkage_(shrinkage(rig)),
      rig_(rig.scaled(shrinkage_)),
      search_(config_, rig_),
      pool_(config_.threads) {}

// The frame as it is searched; it shares what it can with `frame`.
const StereoFrame& Recovery::small(const StereoFrame& frame) {
    small_.index = frame.index;
    small_.capture_time_s = frame.capture_time_s;
    small_.tips = frame.tips;
    small_.instruments = frame.instruments;
    small_.left = frame.left;
    small_.right = frame.right;
    if (shrinkage_ < 1.0) {
        const cv::Size size(rig_.left.width_px, rig_.left.height_px);
        cv::resize(frame.left, shrunk_[0], size, 0.0, 0.0, cv::INTER_AREA);
        cv::resize(frame.right, shrunk_[1], size, 0.0, 0.0, cv::INTER_AREA);
        small_.left = shrunk_[0];
        small_.right = shrunk_[1];
    }
    return small_;
}

std::optional<NurbsCurve> Recovery::near(const StereoFrame& frame, const NurbsCurve& curve) {
    const CurveFitOptions fit{
        .degree = config_.curve.degree, .control_points = config_.curve.control_points, .length_weight = 0.1};
    return curve_of(search_.start(small(frame), fit_curve(sampled(curve, 100), fit)).control_points);
}

std::optional<NurbsCurve> Recovery::along_modes(const StereoFrame& frame,
                                                const Eigen::Matrix3Xd& control_points, double length_m,
                                                const DeformationModes& modes) {
    if (!mode_search_) mode_search_.emplace(config_, rig_, static_cast<int>(control_points.cols()));
    const Eigen::Matrix3Xd moved =
        mode_search_->nearest(small(frame), control_points, length_m, modes, pool_);
    std::vector<Eigen::Vector3d> points;
    for (int k = 0; k < moved.cols(); ++k) points.emplace_back(moved.col(k));
    return near(frame, NurbsCurve(3, std::move(points)));
}

std::optional<NurbsCurve> Recovery::between_tips(const StereoFrame& frame) {
    const auto found = initial_curve_between_tips(config_, rig_, small(frame), pool_, kLevels);
    if (!found) return std::nullopt;
    return curve_of(*found);
}

std::optional<NurbsCurve> Recovery::traced(const StereoFrame& frame) {
    if (!frame.tips[0] || !frame.tips[1]) return std::nullopt;
    if (!finder_) finder_.emplace(rig_, finder_options(config_));
    const std::optional<FoundThread> found = finder_->find(small(frame));
    if (!found || found->doubt != Doubt::kNone) return between_ends();
    scenes::Polyline line = sampled(found->curve, kTracedPoints);
    const auto apart_m = [&] {
        return std::array{(line.points.front() - frame.tips[0]->p_C).norm(),
                          (line.points.back() - frame.tips[1]->p_C).norm()};
    };
    const std::array as_found = apart_m();
    std::reverse(line.points.begin(), line.points.end());
    if (const std::array turned = apart_m(); as_found[0] + as_found[1] < turned[0] + turned[1])
        std::reverse(line.points.begin(), line.points.end());
    for (const double d : apart_m())
        if (d > kJaws_m) return between_ends();
    line.points.insert(line.points.begin(), frame.tips[0]->p_C);
    line.points.push_back(frame.tips[1]->p_C);
    const double known_m = config_.thread.length_m;
    if (known_m > 0.0 && std::abs(line.length_m() - known_m) > kLengthError * known_m) return between_ends();
    return fitted(line);
}

// The same without a finder's doubts: the ends and the length tell which line is the thread.
std::optional<NurbsCurve> Recovery::between_ends() {
    if (!end_to_end_)
        end_to_end_.emplace(rig_, EndToEndOptions{.channel = config_.thread.channel,
                                                  .ridge = {.polarity = config_.thread.polarity}});
    const std::optional<scenes::Polyline> line = end_to_end_->find(small_, config_.thread.length_m);
    if (!line) return std::nullopt;
    return fitted(*line);
}

std::optional<NurbsCurve> Recovery::curve_of(const std::vector<Eigen::Vector3d>& control_points) const {
    if (control_points.empty()) return std::nullopt;
    for (const Eigen::Vector3d& q : control_points)
        if (!q.allFinite()) return std::nullopt;
    NurbsCurve curve(config_.curve.degree, control_points);
    if (share_across_view(sampled(curve, 100)) < kLeastAcross) return std::nullopt;
    return curve;
}

}  // namespace atropos::tracker
