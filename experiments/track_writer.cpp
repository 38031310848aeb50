#include "experiments/track_writer.hpp"

#include <algorithm>
#include <cmath>

namespace atropos::experiments {
using Eigen::Vector3d;
using nlohmann::ordered_json;
using scenes::ThreadEstimate;
using scenes::ThreadSample;
using scenes::TrackStatus;

ThreadEstimate resampled(const ThreadEstimate& estimate, int count) {
    ThreadEstimate result = estimate;
    const auto& from = estimate.samples;
    if (from.size() < 2 || from.size() == static_cast<size_t>(count)) return result;
    result.samples.resize(static_cast<size_t>(count));
    size_t i = 1;
    for (int k = 0; k < count; ++k) {
        const double s = from.back().s_m * k / (count - 1);
        while (i + 1 < from.size() && from[i].s_m < s) ++i;
        const ThreadSample &a = from[i - 1], &b = from[i];
        const double t = std::clamp((s - a.s_m) / (b.s_m - a.s_m), 0.0, 1.0);
        const auto mix = [t](auto x, auto y) { return (1.0 - t) * x + t * y; };
        result.samples[static_cast<size_t>(k)] = {
            s, mix(a.p_C, b.p_C), mix(a.sigma_lateral_m, b.sigma_lateral_m),
            mix(a.sigma_depth_m, b.sigma_depth_m), mix(a.sigma_along_m, b.sigma_along_m)};
    }
    return result;
}

void TrackWriter::add(const tracker::TrackResult& result) {
    const ThreadEstimate estimate = resampled(result.estimate, kTrackSamples);
    const auto out = [](std::string& text) { return std::back_inserter(text); };
    for (size_t i = 0; i < estimate.samples.size(); ++i) {
        const ThreadSample& s = estimate.samples[i];
        const Vector3d p = 1e3 * s.p_C;
        fmt::format_to(out(track_), "{},{},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f}\n", result.frame, i,
                       1e3 * s.s_m, p.x(), p.y(), p.z(), 1e3 * s.sigma_lateral_m, 1e3 * s.sigma_depth_m);
    }
    if (estimate.status != TrackStatus::kLost)
        for (size_t k = 0; k < result.control_points.size(); ++k) {
            const Vector3d p = 1e3 * result.control_points[k];
            fmt::format_to(out(control_points_), "{},{},{:.6f},{:.6f},{:.6f}\n", result.frame, k, p.x(),
                           p.y(), p.z());
        }
    fmt::format_to(out(frames_), "{},{:.6f},{},{:.5f},{:.6f},{:.4f}\n", result.frame, estimate.capture_time_s,
                   scenes::to_string(estimate.status), 1e3 * estimate.length_m(), result.energy.total,
                   estimate.confidence);
    ++status_counts_[scenes::to_string(estimate.status)];
}

void TrackWriter::add_state(const tracker::TrackerState& state) {
    states_ += to_json(state).dump() + "\n";
}

void TrackWriter::add_timings(const tracker::StageTimings& t) {
    timings_ms_["cost_images"].push_back(t.cost_images_ms);
    timings_ms_["potentials"].push_back(t.potentials_ms);
    timings_ms_["optimiser"].push_back(t.optimiser_ms);
    timings_ms_["refinement"].push_back(t.refinement_ms);
    timings_ms_["total"].push_back(t.total_ms);
}

void TrackWriter::write(const std::filesystem::path& folder, ordered_json meta) const {
    std::filesystem::create_directories(folder);
    write_file(folder / "track.csv", track_);
    write_file(folder / "control_points.csv", control_points_);
    write_file(folder / "frames.csv", frames_);
    write_file(folder / "states.jsonl", states_);
    ordered_json timing;
    for (auto [stage, values] : timings_ms_) {
        std::sort(values.begin(), values.end());
        const auto at = [&v = values](double share) {
            return v[std::min(v.size() - 1, static_cast<size_t>(share * static_cast<double>(v.size())))];
        };
        timing["stages"][stage] = {{"median_ms", at(0.5)}, {"p99_ms", at(0.99)}};
    }
    write_file(folder / "timing.json", timing.dump(2) + "\n");
    for (const auto& [status, count] : status_counts_) meta["status"][status] = count;
    meta["complete"] = true;
    write_file(folder / "meta.json", meta.dump(2) + "\n");
}

namespace {

ordered_json points_json(const std::vector<Vector3d>& points) {
    ordered_json json = ordered_json::array();
    for (const Vector3d& p : points) json.push_back({p.x(), p.y(), p.z()});
    return json;
}

std::vector<Vector3d> points_from(const ordered_json& json) {
    std::vector<Vector3d> points;
    for (const auto& p : json)
        points.emplace_back(p.at(0).get<double>(), p.at(1).get<double>(), p.at(2).get<double>());
    return points;
}

}  // namespace

ordered_json to_json(const tracker::TrackerState& s) {
    return {{"started", s.started},
            {"status", scenes::to_string(s.status)},
            {"frames_unseen", s.frames_unseen},
            {"capture_time_s", s.capture_time_s},
            {"control_points_m", points_json(s.control_points)},
            {"reference_control_points_m", points_json(s.reference_control_points)},
            {"method_state", s.method_state}};
}

tracker::TrackerState state_from_json(const ordered_json& json) {
    try {
        tracker::TrackerState s;
        s.started = json.at("started").get<bool>();
        const std::string status = json.at("status").get<std::string>();
        s.status = status == "tracking"   ? TrackStatus::kTracking
                   : status == "coasting" ? TrackStatus::kCoasting
                                          : TrackStatus::kLost;
        s.frames_unseen = json.at("frames_unseen").get<int>();
        s.capture_time_s = json.at("capture_time_s").get<double>();
        s.control_points = points_from(json.at("control_points_m"));
        s.reference_control_points = points_from(json.at("reference_control_points_m"));
        s.method_state = json.at("method_state").get<std::vector<double>>();
        return s;
    } catch (const nlohmann::json::exception&) {
        throw std::invalid_argument("no tracker state");
    }
}

}  // namespace atropos::experiments
