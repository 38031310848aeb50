#include "experiments/metrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace atropos::experiments {
using Eigen::Vector2d;
using Eigen::Vector3d;
using scenes::Polyline;
using scenes::ThreadEstimate;
using scenes::TrackStatus;
namespace {

constexpr double kFailure2d_px = 5.0;
constexpr double kSilent3d_mm = 3.0;
constexpr int kGoodFramesToReacquire = 5;

/// Mean distance from the points of one curve to the other.
double one_sided(const Polyline& from, const Polyline& to) {
    double sum = 0.0;
    for (const Vector3d& p : from.points) sum += to.nearest(p).distance_m;
    return sum / static_cast<double>(from.points.size());
}

/// The image of a curve as a polyline with z = 0, in px.
Polyline image_of(const Polyline& curve, const scenes::StereoRig& rig, int eye) {
    Polyline image;
    for (const Vector3d& p : curve.points) {
        const Vector2d px = eye == 0 ? rig.project_left(p) : rig.project_right(p);
        image.points.emplace_back(px.x(), px.y(), 0.0);
    }
    return image;
}

/// How far `end` is shifted along the curve's tangent at its first point.
double slide(const Polyline& image, const Vector3d& end) {
    const Vector3d tangent = (image.points[1] - image.points[0]).normalized();
    return std::abs((end - image.points[0]).dot(tangent));
}

Polyline reversed(Polyline curve) {
    std::reverse(curve.points.begin(), curve.points.end());
    return curve;
}

void add_coverage(const ThreadEstimate& estimate, const Polyline& truth_C, FrameMetrics& m) {
    const double share = 1.0 / static_cast<double>(estimate.samples.size());
    for (const scenes::ThreadSample& sample : estimate.samples) {
        const Vector3d offset = truth_C.nearest(sample.p_C).point - sample.p_C, ray = sample.p_C.normalized();
        const double depth = std::abs(offset.dot(ray)), lateral = (offset - offset.dot(ray) * ray).norm();
        if (depth <= sample.sigma_depth_m) m.coverage_depth_1_sigma += share;
        if (depth <= 2.0 * sample.sigma_depth_m) m.coverage_depth_2_sigma += share;
        if (lateral <= sample.sigma_lateral_m) m.coverage_lateral_1_sigma += share;
        if (lateral <= 2.0 * sample.sigma_lateral_m) m.coverage_lateral_2_sigma += share;
    }
}

}  // namespace

const std::vector<std::pair<std::string, double FrameMetrics::*>>& metric_fields() {
    using M = FrameMetrics;
    static const std::vector<std::pair<std::string, double M::*>> fields = {
        {"accuracy_3d_mm", &M::accuracy_3d_mm},
        {"accuracy_2d_px", &M::accuracy_2d_px},
        {"symmetric_3d_mm", &M::symmetric_3d_mm},
        {"symmetric_2d_px", &M::symmetric_2d_px},
        {"disparity_equivalent_px", &M::disparity_equivalent_px},
        {"arc_length_3d_mm", &M::arc_length_3d_mm},
        {"midpoint_mm", &M::midpoint_mm},
        {"tip_mm", &M::tip_mm},
        {"end_slide_px", &M::end_slide_px},
        {"length_error_percent", &M::length_error_percent},
        {"coverage_depth_1_sigma", &M::coverage_depth_1_sigma},
        {"coverage_depth_2_sigma", &M::coverage_depth_2_sigma},
        {"coverage_lateral_1_sigma", &M::coverage_lateral_1_sigma},
        {"coverage_lateral_2_sigma", &M::coverage_lateral_2_sigma},
    };
    return fields;
}

FrameMetrics compare(const ThreadEstimate& estimate, const Polyline& truth_C, const scenes::StereoRig& rig) {
    Polyline curve;
    for (const auto& sample : estimate.samples) curve.points.push_back(sample.p_C);
    FrameMetrics m;
    const double forward = one_sided(curve, truth_C), backward = one_sided(truth_C, curve);
    m.accuracy_3d_mm = 1e3 * forward;
    m.symmetric_3d_mm = 1e3 * 0.5 * (forward + backward);
    for (const int eye : {0, 1}) {
        const Polyline image = image_of(curve, rig, eye), true_image = image_of(truth_C, rig, eye);
        const double forward_px = one_sided(image, true_image);
        m.accuracy_2d_px += 0.5 * forward_px;
        m.symmetric_2d_px += 0.25 * (forward_px + one_sided(true_image, image));
        m.end_slide_px += 0.25 * (slide(true_image, image.points.front()) +
                                  slide(reversed(true_image), image.points.back()));
    }
    double z = 0.0;
    for (const Vector3d& p : truth_C.points) z += p.z() / static_cast<double>(truth_C.points.size());
    m.disparity_equivalent_px = forward / rig.m_per_disparity_px(z);

    const double true_length = truth_C.length_m(), length = curve.length_m();
    const Polyline true_steps = truth_C.resampled(1001);
    for (const auto& sample : estimate.samples) {
        const double at = std::clamp(sample.s_m / true_length, 0.0, 1.0) * 1000.0;
        const auto i = std::min<size_t>(static_cast<size_t>(at), 999);
        const double t = at - static_cast<double>(i);
        const Vector3d p = (1.0 - t) * true_steps.points[i] + t * true_steps.points[i + 1];
        m.arc_length_3d_mm += 1e3 * (p - sample.p_C).norm() / static_cast<double>(estimate.samples.size());
    }
    m.midpoint_mm = 1e3 * (curve.point_at(0.5 * length) - truth_C.point_at(0.5 * true_length)).norm();
    m.tip_mm = 1e3 * 0.5 *
               ((curve.points.front() - truth_C.points.front()).norm() +
                (curve.points.back() - truth_C.points.back()).norm());
    m.length_error_percent = 100.0 * (length - true_length) / true_length;
    add_coverage(estimate, truth_C, m);
    return m;
}

nlohmann::ordered_json statistics(std::vector<double> values) {
    if (values.empty()) return nullptr;
    const auto n = static_cast<double>(values.size());
    double mean = 0.0, square = 0.0;
    for (const double v : values) mean += v / n;
    for (const double v : values) square += (v - mean) * (v - mean) / n;
    for (double& v : values) v = std::abs(v);  // only the length error is signed: p95 and max are of its size
    std::sort(values.begin(), values.end());
    const auto rank = static_cast<size_t>(std::ceil(0.95 * n)) - 1;
    return {{"mean", mean}, {"std", std::sqrt(square)}, {"p95", values[rank]}, {"max", values.back()}};
}

namespace {

struct Losses {
    int failures = 0, events = 0, silent = 0;
    std::vector<double> reacquire_frames;
};

Losses count_losses(const std::vector<EvaluatedFrame>& frames) {
    Losses losses;
    int since = -1, good = 0;  // frame of the open failure, good frames in a row after it
    for (size_t i = 0; i < frames.size(); ++i) {
        const EvaluatedFrame& f = frames[i];
        const bool bad = !f.has_curve || f.metrics.symmetric_2d_px > kFailure2d_px;
        if (bad) ++losses.failures;
        if (f.has_curve && f.status == TrackStatus::kTracking &&
            (bad || f.metrics.symmetric_3d_mm > kSilent3d_mm))
            ++losses.silent;
        if (bad && since < 0) {
            since = static_cast<int>(i);
            ++losses.events;
        }
        good = bad ? 0 : good + 1;
        if (since >= 0 && good == kGoodFramesToReacquire) {
            losses.reacquire_frames.push_back(static_cast<double>(i) - since - kGoodFramesToReacquire + 1);
            since = -1;
        }
    }
    return losses;
}

}  // namespace

nlohmann::ordered_json summarise(const std::vector<EvaluatedFrame>& frames) {
    nlohmann::ordered_json summary;
    for (const auto& [name, field] : metric_fields()) {
        std::vector<double> values;
        for (const EvaluatedFrame& f : frames)
            if (f.has_curve) values.push_back(f.metrics.*field);
        summary[name] = statistics(values);
    }
    const Losses losses = count_losses(frames);
    const auto lost = std::count_if(frames.begin(), frames.end(),
                                    [](const auto& f) { return f.status == TrackStatus::kLost; });
    summary["frames"] = frames.size();
    summary["lost_frames"] = lost;
    summary["failure_rate"] =
        frames.empty() ? 0.0 : static_cast<double>(losses.failures) / static_cast<double>(frames.size());
    summary["loss_events"] = losses.events;
    summary["reacquire_frames"] = statistics(losses.reacquire_frames);
    summary["silent_failures"] = losses.silent;
    return summary;
}

const std::vector<std::string>& deformation_names() {
    static const std::vector<std::string> names = {"deformation_3d_mm", "deformation_2d_px"};
    return names;
}

nlohmann::ordered_json deformation(const std::vector<Polyline>& spans_C, const scenes::StereoRig& rig) {
    constexpr int kPoints = 8;
    std::vector<double> moved_mm, moved_px;
    for (size_t i = 1; i < spans_C.size(); ++i) {
        const Polyline before = spans_C[i - 1].resampled(kPoints), after = spans_C[i].resampled(kPoints);
        for (size_t k = 0; k < kPoints; ++k) {
            moved_mm.push_back(1e3 * (after.points[k] - before.points[k]).norm());
            moved_px.push_back(
                (rig.project_left(after.points[k]) - rig.project_left(before.points[k])).norm());
        }
    }
    return {{deformation_names()[0], statistics(moved_mm)}, {deformation_names()[1], statistics(moved_px)}};
}

std::string per_frame_csv(const std::vector<EvaluatedFrame>& frames) {
    std::string text = "frame,status";
    for (const auto& [name, field] : metric_fields()) text += "," + name;
    text += "\n";
    for (const EvaluatedFrame& f : frames) {
        text += fmt::format("{},{}", f.frame, scenes::to_string(f.status));
        for (const auto& [name, field] : metric_fields())
            text += f.has_curve ? fmt::format(",{:.6f}", f.metrics.*field) : ",";
        text += "\n";
    }
    return text;
}

std::string summary_table(const nlohmann::ordered_json& summary) {
    std::string text = fmt::format("{:<26}{:>10}{:>10}{:>10}{:>10}\n", "", "mean", "std", "p95", "max");
    for (const auto& [name, value] : summary.items()) {
        if (value.is_object())
            text += fmt::format("{:<26}{:>10.4f}{:>10.4f}{:>10.4f}{:>10.4f}\n", name,
                                value["mean"].get<double>(), value["std"].get<double>(),
                                value["p95"].get<double>(), value["max"].get<double>());
        else if (value.is_null())
            text += fmt::format("{:<26}{:>10}\n", name, "-");
        else if (value.is_number_float())
            text += fmt::format("{:<26}{:>10.4f}\n", name, value.get<double>());
        else
            text += fmt::format("{:<26}{:>10}\n", name, value.dump());
    }
    return text;
}

}  // namespace atropos::experiments
