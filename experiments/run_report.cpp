#include "experiments/run_report.hpp"

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "experiments/output_folder.hpp"
#include "experiments/overlay.hpp"
#include "experiments/track_writer.hpp"
#include "scenes/scene_file.hpp"
#include "scenes/text_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using Eigen::Vector3d;
using nlohmann::ordered_json;

namespace {

constexpr int kFramesPerPicture = 4;
constexpr int kJpegQuality = 72;
constexpr int kCurvePoints = 51;
constexpr size_t kMaxLibraryBytes = 4 << 20;

std::string library(const char* name, const char* package) {
    const fs::path file = fs::path("/usr/share/javascript") / name;
    if (!fs::exists(file))
        throw std::runtime_error("report.html needs " + file.string() + ": apt-get install " + package);
    return scenes::read_text_file(file, kMaxLibraryBytes);
}

void put(std::string& page, const std::string& mark, const std::string& text) {
    const size_t at = page.find(mark);
    if (at == std::string::npos) throw std::runtime_error("scenes/pages/run.html has no mark " + mark);
    page.replace(at, mark.size(), text);
}

double rounded(double mm) {
    return std::round(1e3 * mm) / 1e3;
}

void append(ordered_json& flat, const Vector3d& p_m) {
    for (int k = 0; k < 3; ++k) flat.push_back(std::round(1e5 * p_m[k]) / 1e2);
}

ordered_json flat(const Vector3d& p_m) {
    ordered_json out = ordered_json::array();
    append(out, p_m);
    return out;
}

ordered_json strands(const std::vector<TruthSample>& samples) {
    ordered_json out = ordered_json::array();
    int strand = -1;
    for (size_t i = 0; i < samples.size(); ++i) {
        if (samples[i].strand != strand) out.push_back(ordered_json::array());
        const bool last = i + 1 == samples.size() || samples[i + 1].strand != samples[i].strand;
        if (samples[i].strand != strand || last || i % 2 == 0) append(out.back(), samples[i].p_C);
        strand = samples[i].strand;
    }
    return out;
}

/// Arm number, both ends and the radius of every capsule, mm in C.
ordered_json capsules(const Testbed& testbed) {
    ordered_json out = ordered_json::array();
    const Eigen::Isometry3d X_CW = testbed.X_WC().inverse();
    for (int arm = 0; arm < kArms; ++arm) {
        for (const scenes::Capsule& c : testbed.arm(arm).true_capsules_W().value) {
            ordered_json entry = {arm};
            append(entry, X_CW * c.a);
            append(entry, X_CW * c.b);
            entry.push_back(std::round(1e5 * c.radius_m) / 1e2);
            out.push_back(entry);
        }
    }
    return out;
}

std::string base64(const std::vector<unsigned char>& bytes) {
    static constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        unsigned word = 0;
        for (size_t k = 0; k < 3; ++k) word = word << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
        for (size_t k = 0; k < 4; ++k)
            out += i + k <= bytes.size() ? kLetters[word >> (18 - 6 * k) & 63] : '=';
    }
    return out;
}

std::string jpeg(const cv::Mat& picture) {
    std::vector<unsigned char> bytes;
    cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
    return base64(bytes);
}

/// Root mean square of two sigmas over the curve, mm.
double bound_mm(const scenes::ThreadEstimate& estimate) {
    double sum = 0.0;
    for (const auto& s : estimate.samples)
        sum += 2.0 * s.sigma_lateral_m * s.sigma_lateral_m + s.sigma_depth_m * s.sigma_depth_m;
    return 2e3 * std::sqrt(sum / static_cast<double>(estimate.samples.size()));
}

}  // namespace

RunReport::RunReport()
    : page_(scenes::read_text_file(scenes::resolve_path("", "pages/run.html"), kMaxLibraryBytes)) {
    put(page_, "/*{{dygraph.css}}*/", library("dygraphs/dygraph.min.css", "libjs-dygraphs"));
    put(page_, "/*{{three.js}}*/", library("three/three.min.js", "libjs-three"));
    put(page_, "/*{{orbit.js}}*/", library("three/examples/js/controls/OrbitControls.js", "libjs-three"));
    put(page_, "/*{{dygraph.js}}*/", library("dygraphs/dygraph.min.js", "libjs-dygraphs"));
}

void RunReport::add(const LoopFrame& frame, const ClosedLoop& loop, const scenes::ThreadEstimate& estimate,
                    const std::vector<Vector3d>& control_points, const std::optional<FrameMetrics>& metrics) {
    const robot::ScissorsStatus& command = frame.command;
    ordered_json entry;
    entry["t"] = rounded(loop.testbed().time_s());
    entry["state"] = robot::to_string(command.state);
    entry["status"] = estimate.samples.empty() ? "not tracked" : scenes::to_string(estimate.status);
    entry["gate"] = command.gate_open;
    entry["why"] = command.gate_reason;
    entry["truth"] = strands(frame.view.samples);
    if (!estimate.samples.empty()) {
        ordered_json curve = ordered_json::array();
        for (const auto& sample : resampled(estimate, kCurvePoints).samples) append(curve, sample.p_C);
        entry["tracked"] = curve;
        entry["bound_mm"] = rounded(bound_mm(estimate));
    }
    if (metrics) {
        entry["middle_mm"] = rounded(metrics->midpoint_mm);
        entry["shape_mm"] = rounded(metrics->symmetric_3d_mm);
    }
    entry["capsules"] = capsules(loop.testbed());
    if (command.target_known) {
        entry["target"] = flat(command.target_C);
        entry["distance_mm"] = rounded(1e3 * (command.target_C - command.X_CS.translation()).norm());
        entry["miss_mm"] = rounded(1e3 * command.predicted_miss_m);
    }
    centre_mm_ += 1e3 * frame.view.samples[frame.view.samples.size() / 2].p_C;
    frames_.push_back(entry);
    if (frame.frame % kFramesPerPicture == 0) add_picture(frame, loop, estimate, control_points);
}

void RunReport::add_picture(const LoopFrame& frame, const ClosedLoop& loop,
                            const scenes::ThreadEstimate& estimate,
                            const std::vector<Vector3d>& control_points) {
    scenes::Polyline span;
    for (const TruthSample& s : frame.view.samples)
        if (s.in_span) span.points.push_back(s.p_C);
    const Overlay overlay{&estimate, control_points, &span, ""};
    const scenes::StereoRig& rig = loop.testbed().rig();
    pictures_.push_back({{"frame", frames_.size() - 1},
                         {"left", jpeg(draw_overlay(frame.view.left, rig, 0, overlay))},
                         {"right", jpeg(draw_overlay(frame.view.right, rig, 1, overlay))}});
}

void RunReport::write(const fs::path& file, const ordered_json& summary, const ClosedLoop& loop) const {
    const double count = std::max<double>(1.0, static_cast<double>(frames_.size()));
    size_t first = 0;
    for (size_t k = 0; k < frames_.size(); ++k)
        if (frames_[k]["state"] == "close" || (first == 0 && frames_[k]["state"] == "follow")) first = k;
    ordered_json data;
    data["summary"] = summary;
    data["step_s"] = 1.0 / loop.testbed().scene().camera.fps_hz;
    data["centre"] = {centre_mm_.x() / count, centre_mm_.y() / count, centre_mm_.z() / count};
    data["first"] = first;
    data["frames"] = frames_;
    data["pictures"] = pictures_;
    std::string text = data.dump();
    // A scene's name must not end the script that it stands in.
    for (size_t at = text.find("</"); at != std::string::npos; at = text.find("</", at + 3))
        text.replace(at, 2, "<\\/");
    std::string page = page_;
    put(page, "/*{{data}}*/", text);
    write_file(file, page);
}

}  // namespace atropos::experiments
