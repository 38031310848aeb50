#include "experiments/run_recorder.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "experiments/output_folder.hpp"
#include "experiments/outside_view.hpp"
#include "experiments/overlay.hpp"
#include "experiments/sequence_writer.hpp"
#include "experiments/version.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using Eigen::Vector2d;
using Eigen::Vector3d;
using nlohmann::ordered_json;

RunRecorder::RunRecorder(fs::path folder, const ClosedLoop& loop, bool video)
    : folder_(std::move(folder)), loop_(loop), wants_video_(video) {
    fs::create_directories(folder_ / "truth");
    write_file(folder_ / "scene.yaml", scenes::to_yaml(loop.testbed().scene()));
    loop_csv_ =
        AppendFile(folder_ / "loop.csv",
                   "frame,time_s,state,target_x_mm,target_y_mm,target_z_mm,blade_x_mm,blade_y_mm,blade_z_mm,"
                   "predicted_miss_mm,gate,gate_reason\n");
    thread_ = AppendFile(folder_ / "truth" / "thread.csv", std::string(kTruthThreadColumns) + "\n");
}

void RunRecorder::add(const LoopFrame& frame) {
    frame_times_s_.push_back(loop_.testbed().time_s());
    write_truth(frame);
    write_loop(frame);
    if (frame.tracked) {
        track_.add(*frame.tracked);
        track_.add_state(loop_.tracker().state());
        track_.add_timings(loop_.tracker().timings());
        last_estimate_ = frame.tracked->estimate;
        last_control_points_ = frame.tracked->control_points;
        add_metrics(frame);
    } else if (frame.command.verified == robot::CutEvidence::kCut) {
        last_estimate_ = {};  // nothing is tracked any more
        last_control_points_.clear();
    }
    const bool measured = frame.tracked && !evaluated_.empty() && evaluated_.back().frame == frame.frame;
    report_.add(
        frame, loop_, last_estimate_, last_control_points_,
        measured && evaluated_.back().has_curve ? std::optional(evaluated_.back().metrics) : std::nullopt);
    if (wants_video_) draw(frame);
}

void RunRecorder::write_truth(const LoopFrame& frame) {
    thread_.write(truth_rows(frame.frame, frame.view.samples));
    scenes::Polyline span;
    for (const TruthSample& s : frame.view.samples)
        if (s.in_span) span.points.push_back(s.p_C);
    if (span.points.size() < 2) return;
    const Vector3d middle = span.point_at(0.5 * span.length_m());
    middles_.emplace_back(middle, loop_.testbed().rig().project_left(middle));
}

void RunRecorder::write_loop(const LoopFrame& frame) {
    const robot::ScissorsStatus& s = frame.command;
    const auto place = [&](const Vector3d& p) {
        return s.target_known ? fmt::format("{:.4f},{:.4f},{:.4f}", 1e3 * p.x(), 1e3 * p.y(), 1e3 * p.z())
                              : std::string(",,");
    };
    loop_csv_.write(fmt::format("{},{:.6f},{},{},{},{},{},{}\n", frame.frame, frame_times_s_.back(),
                                robot::to_string(s.state), place(s.target_C), place(s.X_CS.translation()),
                                s.target_known ? fmt::format("{:.4f}", 1e3 * s.predicted_miss_m) : "",
                                s.gate_open ? 1 : 0, s.gate_reason));
}

void RunRecorder::add_metrics(const LoopFrame& frame) {
    scenes::Polyline span;
    for (const TruthSample& s : frame.view.samples)
        if (s.in_span) span.points.push_back(s.p_C);
    if (span.points.size() < 2) return;
    const scenes::ThreadEstimate estimate = resampled(frame.tracked->estimate, kTrackSamples);
    EvaluatedFrame f{frame.frame, estimate.status, estimate.samples.size() >= 2, {}};
    if (f.has_curve) f.metrics = compare(estimate, span, loop_.testbed().rig());
    evaluated_.push_back(f);
}

void RunRecorder::draw(const LoopFrame& frame) {
    constexpr int kZoom = 2, kFramesPerInset = 3;
    const Overlay overlay{
        &last_estimate_, last_control_points_, nullptr,
        fmt::format("{:6.2f} s  {}  {}", frame_times_s_.back(), robot::to_string(frame.command.state),
                    last_estimate_.samples.empty() ? "" : scenes::to_string(last_estimate_.status))};
    const cv::Mat picture = draw_overlay(frame.view.left, loop_.testbed().rig(), 0, overlay, kZoom);
    const cv::Size inset(picture.cols / 4, picture.rows / 3);
    if (frame.frame % kFramesPerInset == 0 || inset_.empty())
        inset_ = draw_outside_view(loop_.testbed(), frame.view.samples, last_estimate_, inset);
    inset_.copyTo(picture(cv::Rect({picture.cols - inset.width, picture.rows - inset.height}, inset)));
    if (!video_)
        video_ = std::make_unique<VideoWriter>(folder_ / "video.mp4", picture.size(),
                                               loop_.testbed().scene().camera.fps_hz);
    video_->add(picture);
}

namespace {

std::optional<sim::Event> first_cut(const std::vector<sim::Event>& events) {
    for (const sim::Event& event : events)
        if (event.kind == sim::EventKind::kCut) return event;
    return std::nullopt;
}

}  // namespace

ordered_json RunRecorder::budget() const {
    const robot::ErrorBudget& b = loop_.status().budget;
    return {{"tracking_mm", 1e3 * b.tracking_m},
            {"registration_mm", 1e3 * b.registration_m},
            {"prediction_mm", 1e3 * b.prediction_m},
            {"mechanics_mm", 1e3 * b.mechanics_m}};
}

/// Mean speed of the true middle up to the end, in space and in the left image.
ordered_json RunRecorder::motion() const {
    double way_m = 0.0, way_px = 0.0;
    for (size_t i = 1; i < middles_.size(); ++i) {
        way_m += (middles_[i].first - middles_[i - 1].first).norm();
        way_px += (middles_[i].second - middles_[i - 1].second).norm();
    }
    const double steps = middles_.size() > 1 ? static_cast<double>(middles_.size() - 1) : 1.0;
    return {{"middle_mm_s", 1e3 * way_m / steps * loop_.testbed().scene().camera.fps_hz},
            {"middle_px_per_frame", way_px / steps}};
}

ordered_json RunRecorder::judge() const {
    const scenes::SceneConfig& scene = loop_.testbed().scene();
    const auto& events = loop_.testbed().world().events();
    ordered_json summary;
    summary["scene"] = scene.name;
    summary["seed"] = scene.seed;
    int collisions = 0;
    for (const sim::Event& event : events) collisions += event.kind == sim::EventKind::kCollision ? 1 : 0;
    const std::optional<sim::Event> cut = first_cut(events);
    const robot::ScissorsStatus& status = loop_.status();
    if (cut) {
        // The holders' places on the thread don't change by the cut: its span is still the one to judge by.
        const sim::JudgedSpan span = loop_.testbed().thread().span;
        const double wanted_m = span.s0_m + scene.cut.fraction * (span.s1_m - span.s0_m);
        const double error_m = cut->s_m - wanted_m;
        const bool inside = std::abs(error_m) <= scene.cut.tolerance_m;
        summary["verdict"] = inside ? "cut" : "missed";
        summary["reason"] =
            fmt::format("the thread was cut {:.2f} mm from the place asked for, tolerance {:.2f} mm{}",
                        1e3 * std::abs(error_m), 1e3 * scene.cut.tolerance_m,
                        status.reason.empty() ? "" : "; " + status.reason);
        summary["cut"] = {{"time_s", cut->time_s},
                          {"s_mm", 1e3 * cut->s_m},
                          {"error_mm", 1e3 * error_m},
                          {"budget", budget()}};
    } else if (status.close_time_s >= 0.0 && !status.finished) {
        summary["verdict"] = "missed";
        summary["reason"] = "the blades closed and the thread is whole";
    } else {
        summary["verdict"] = status.close_time_s >= 0.0 ? "missed" : "aborted";
        summary["reason"] = status.reason.empty() ? "the scene ended before the cut" : status.reason;
    }
    summary["collisions"] = collisions;
    summary["attempts"] = status.attempts;
    summary["metrics"] = summarise(evaluated_);
    summary["motion"] = motion();
    return summary;
}

ordered_json RunRecorder::finish(double wall_s) {
    loop_csv_.close();
    thread_.close();
    if (video_) video_->close();
    const scenes::SceneConfig& scene = loop_.testbed().scene();
    write_file(folder_ / "events.csv", events_csv(loop_.testbed().world().events(), frame_times_s_,
                                                  loop_.testbed().X_WC().inverse()));
    track_.write(
        folder_ / "track",
        {{"sequence", scene.name}, {"frames", frame_times_s_.size()}, {"version", version_number()}});
    const ordered_json summary = judge();
    write_file(folder_ / "summary.json", summary.dump(2) + "\n");
    report_.write(folder_ / "report.html", summary, loop_);
    ordered_json timing;
    for (const auto& [stage, seconds] : loop_.clock().seconds()) timing["seconds"][stage] = seconds;
    timing["wall_s"] = wall_s;
    timing["simulated_s"] = loop_.testbed().time_s();
    timing["realtime_factor"] = loop_.testbed().time_s() / wall_s;
    write_file(folder_ / "timing.json", timing.dump(2) + "\n");
    return summary;
}

}  // namespace atropos::experiments
