#include "experiments/external_tracker.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "scenes/text_file.hpp"

namespace atropos::experiments {
using Eigen::Vector3d;
using nlohmann::ordered_json;
using scenes::TrackStatus;
using tracker::StereoFrame;
using tracker::TrackResult;
namespace {

using Clock = std::chrono::steady_clock;
using Outcome = ChildProcess::Outcome;
constexpr std::size_t kMaxPoints = 100000;

template <class Matrix>
ordered_json rows_of(const Matrix& m) {
    ordered_json rows = ordered_json::array();
    for (Eigen::Index r = 0; r < m.rows(); ++r) {
        ordered_json row = ordered_json::array();
        for (Eigen::Index c = 0; c < m.cols(); ++c) row.push_back(m(r, c));
        rows.push_back(std::move(row));
    }
    return rows;
}

ordered_json vector_of(const Vector3d& v) {
    return {v.x(), v.y(), v.z()};
}

/// OpenCV's names, T in mm.
ordered_json calibration_json(const scenes::StereoRig& rig) {
    return {{"M1", rows_of(rig.left.K())},     {"D1", rig.left.distortion},
            {"M2", rows_of(rig.right.K())},    {"D2", rig.right.distortion},
            {"R", rows_of(rig.X_RC.linear())}, {"T", vector_of(1e3 * rig.X_RC.translation())}};
}

ordered_json tips_json(const StereoFrame& frame) {
    ordered_json tips = ordered_json::array();
    for (const auto& tip : frame.tips) {
        if (!tip)
            tips.push_back(nullptr);
        else
            tips.push_back({{"kind", tip->kind == tracker::MeasuredTip::Kind::kFixed ? "fixed" : "held"},
                            {"p_mm", vector_of(1e3 * tip->p_C)}});
    }
    return tips;
}

ordered_json capsules_json(const StereoFrame& frame) {
    ordered_json capsules = ordered_json::array();
    for (const scenes::Capsule& c : frame.instruments)
        capsules.push_back({{"a_mm", vector_of(1e3 * c.a)},
                            {"b_mm", vector_of(1e3 * c.b)},
                            {"radius_mm", 1e3 * c.radius_m}});
    return capsules;
}

/// A number for all samples, or one each, in mm; what isn't given is 0, unknown.
std::vector<double> sigmas_mm(const ordered_json& answer, const char* key, std::size_t count) {
    if (!answer.contains(key)) return std::vector<double>(count, 0.0);
    const ordered_json& value = answer.at(key);
    std::vector<double> sigmas =
        value.is_array() ? value.get<std::vector<double>>() : std::vector<double>(count, value.get<double>());
    if (sigmas.size() != count)
        throw std::invalid_argument(fmt::format("{} has {} numbers, expected {}", key, sigmas.size(), count));
    for (const double sigma : sigmas)
        if (!(sigma >= 0.0) || !std::isfinite(sigma))
            throw std::invalid_argument(std::string(key) + " is no length of at least 0");
    return sigmas;
}

std::vector<scenes::ThreadSample> samples_of(const ordered_json& answer) {
    const auto points = answer.at("curve_mm").get<std::vector<std::vector<double>>>();
    if (points.size() < 2 || points.size() > kMaxPoints)
        throw std::invalid_argument(
            fmt::format("curve_mm has {} points, expected 2 to {}", points.size(), kMaxPoints));
    const std::vector<double> lateral = sigmas_mm(answer, "sigma_lateral_mm", points.size()),
                              depth = sigmas_mm(answer, "sigma_depth_mm", points.size());
    std::vector<scenes::ThreadSample> samples;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (points[i].size() != 3) throw std::invalid_argument("curve_mm holds a point that is not x, y, z");
        const Vector3d p(1e-3 * points[i][0], 1e-3 * points[i][1], 1e-3 * points[i][2]);
        if (!p.allFinite() || p.z() < 1e-3)
            throw std::invalid_argument("curve_mm holds a point that is not before the camera");
        const double s_m = samples.empty() ? 0.0 : samples.back().s_m + (p - samples.back().p_C).norm();
        if (!samples.empty() && s_m <= samples.back().s_m)
            throw std::invalid_argument("curve_mm holds a point twice in a row");
        samples.push_back({s_m, p, 1e-3 * lateral[i], 1e-3 * depth[i]});
    }
    return samples;
}

}  // namespace

ExternalTracker::ExternalTracker(ExternalTrackerOptions options, scenes::StereoRig rig, Log log)
    : options_(std::move(options)),
      rig_(std::move(rig)),
      log_(std::move(log)),
      calibration_(calibration_json(rig_).dump()) {}

const TrackResult& ExternalTracker::track(const StereoFrame& frame) {
    return exchange(frame, "");
}

const TrackResult& ExternalTracker::start(const StereoFrame& frame, const tracker::NurbsCurve& initial) {
    ordered_json points = ordered_json::array();
    for (int i = 0; i <= 100; ++i) points.push_back(vector_of(1e3 * initial.point(0.01 * i)));
    return exchange(frame, ",\"initial_mm\":" + points.dump());
}

const TrackResult& ExternalTracker::exchange(const StereoFrame& frame, const std::string& more) {
    tracker::check_frame(frame, rig_);
    const auto begin = Clock::now();
    result_ = TrackResult{};
    result_.frame = frame.index;
    result_.estimate.capture_time_s = frame.capture_time_s;
    const std::string request = fmt::format(
        "{{\"frame\":{},\"time_s\":{},\"width\":{},\"height\":{},\"channels\":{},\"calibration\":{},\"tips\":"
        "{},"
        "\"instruments\":{}{}}}\n",
        frame.index, frame.capture_time_s, frame.left.cols, frame.left.rows, frame.left.channels(),
        calibration_, tips_json(frame).dump(), capsules_json(frame).dump(), more);
    if (bad_starts_ < options_.restarts && ask(frame, request)) bad_starts_ = 0;
    timings_.total_ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    return result_;
}

bool ExternalTracker::ask(const StereoFrame& frame, const std::string& request) {
    const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                             std::chrono::duration<double>(options_.timeout_s));
    if (!child_) child_ = std::make_unique<ChildProcess>(options_.command);
    const auto bytes = [](const unsigned char* data, std::size_t size) { return std::span(data, size); };
    const cv::Mat left = frame.left.isContinuous() ? frame.left : frame.left.clone(),
                  right = frame.right.isContinuous() ? frame.right : frame.right.clone();
    std::string line;
    Outcome outcome =
        child_->send({bytes(reinterpret_cast<const unsigned char*>(request.data()), request.size()),
                      bytes(left.data, left.total() * left.elemSize()),
                      bytes(right.data, right.total() * right.elemSize())},
                     deadline);
    while (outcome == Outcome::kDone) {
        outcome = child_->read_line(line, deadline);
        if (outcome != Outcome::kDone) break;
        const ordered_json answer = ordered_json::parse(line, nullptr, false);
        if (!answer.is_object() || !answer.contains("frame") || !answer["frame"].is_number_integer())
            return lost("the answer is " + scenes::shown(line) + ", expected a JSON line with its frame",
                        false);
        if (answer["frame"].get<std::int64_t>() == frame.index) return accept(line);
        if (answer["frame"].get<std::int64_t>() > frame.index)
            return lost("the answer is for a frame to come", true);
    }
    switch (outcome) {
        case Outcome::kTimeout:
            return lost(fmt::format("no answer within {} s", options_.timeout_s), true);
        case Outcome::kTooLong:
            return lost("an answer without an end", true);
        default:
            return lost("the tracker ended or closed its pipe", true);
    }
}

bool ExternalTracker::accept(const std::string& line) {
    try {
        const ordered_json answer = ordered_json::parse(line);
        const std::string status = answer.at("status").get<std::string>();
        if (status == "lost") return true;
        if (status != "tracking" && status != "coasting")
            return lost("status is " + scenes::shown(status) + ", expected tracking, coasting or lost",
                        false);
        const double confidence = answer.value("confidence", 1.0);
        if (!(confidence >= 0.0 && confidence <= 1.0)) return lost("confidence is not in 0 to 1", false);
        result_.estimate.samples = samples_of(answer);
        result_.estimate.status = status == "tracking" ? TrackStatus::kTracking : TrackStatus::kCoasting;
        result_.estimate.confidence = confidence;
        return true;
    } catch (const nlohmann::json::exception&) {
        return lost("the answer lacks status or curve_mm, or they are not what they should be", false);
    } catch (const std::invalid_argument& error) {
        return lost(error.what(), false);
    }
}

bool ExternalTracker::lost(const std::string& why, bool end_child) {
    log_(fmt::format("frame {}: lost: {}", result_.frame, why));
    if (!end_child) return false;
    child_.reset();
    if (++bad_starts_ == options_.restarts)
        log_(fmt::format("frame {}: given up after {} starts without an answer; lost from here on",
                         result_.frame, options_.restarts));
    return false;
}

tracker::TrackerState ExternalTracker::state() const {
    tracker::TrackerState state;
    state.status = result_.estimate.status;
    state.started = state.status != TrackStatus::kLost;
    state.capture_time_s = result_.estimate.capture_time_s;
    return state;
}

void ExternalTracker::restore(const tracker::TrackerState&) {
    throw std::invalid_argument(
        "--tracker: an external tracker keeps its own state, which can't be restored");
}

std::unique_ptr<tracker::StereoTracker> make_external_tracker(const ExternalTrackerOptions& options,
                                                              const scenes::StereoRig& rig, std::string& log,
                                                              bool quiet) {
    return std::make_unique<ExternalTracker>(options, rig, [&log, quiet](const std::string& line) {
        log += line + "\n";
        if (!quiet) fmt::print(stderr, "tracker: {}\n", line);
    });
}

}  // namespace atropos::experiments
