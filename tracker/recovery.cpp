#include "tracker/recovery.hpp"

namespace atropos::tracker {
namespace {

/// Seven control points or eight are few enough for pairs of labels to move every part of the curve.
scenes::TrackerConfig search_config(scenes::TrackerConfig config) {
    config.method = scenes::TrackerMethod::kE2;
    config.optimiser = scenes::LabelOptimiser::kDynamicProgramming;
    config.parameterisation = scenes::Parameterisation::k3d;
    config.thread.length_is_known = config.thread.length_m > 0.0;
    config.curve.control_points = 8;
    config.curve.degree = 3;
    config.labels.shape = scenes::LabelShape::kRays;
    config.labels.preset = scenes::LabelPreset::kCustom;
    config.lambda1_e2 = 100.0;
    return config;
}

}  // namespace

Recovery::Recovery(scenes::TrackerConfig config, const scenes::StereoRig& rig)
    : degree_(3), control_points_(8), search_(search_config(config), rig) {}

std::optional<NurbsCurve> Recovery::near(const StereoFrame& frame, const NurbsCurve& curve) {
    const CurveFitOptions fit{.degree = degree_, .control_points = control_points_, .length_weight = 0.1};
    return curve_of(search_.start(frame, fit_curve(sampled(curve, 100), fit)));
}

std::optional<NurbsCurve> Recovery::between_tips(const StereoFrame& frame) {
    search_.restore(TrackerState{});
    return curve_of(search_.track(frame));
}

std::optional<NurbsCurve> Recovery::curve_of(const TrackResult& result) const {
    if (result.control_points.empty()) return std::nullopt;
    for (const Eigen::Vector3d& q : result.control_points)
        if (!q.allFinite()) return std::nullopt;
    return NurbsCurve(degree_, result.control_points);
}

}  // namespace atropos::tracker
