#pragma once

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/output_folder.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::experiments {

constexpr int kTrackSamples = 101;

/// The estimate at `count` equal steps of arc length, sigmas interpolated. Lost estimates stay empty.
scenes::ThreadEstimate resampled(const scenes::ThreadEstimate& estimate, int count);

/// Collects a track frame by frame and writes its folder (design: "Track"): track.csv, control_points.csv,
/// frames.csv, states.jsonl (what --explain starts from), meta.json, timing.json.
class TrackWriter {
  public:
    void add(const tracker::TrackResult& result);
    void add_state(const tracker::TrackerState& state);
    void add_timings(const tracker::StageTimings& timings);

    /// `meta` is completed by frame counts and "complete": true.
    void write(const std::filesystem::path& folder, nlohmann::ordered_json meta) const;

  private:
    std::string track_ = "frame,i,s_mm,x_mm,y_mm,z_mm,sigma_lateral_mm,sigma_depth_mm\n";
    std::string control_points_ = "frame,k,x_mm,y_mm,z_mm\n";
    std::string frames_ = "frame,time_s,status,length_mm,energy,confidence\n";
    std::string states_;
    std::map<std::string, std::vector<double>> timings_ms_;
    std::map<std::string, int> status_counts_;
};

/// A tracker's state as JSON, exact to the bit, and back. Throws std::invalid_argument.
nlohmann::ordered_json to_json(const tracker::TrackerState& state);
tracker::TrackerState state_from_json(const nlohmann::ordered_json& json);

}  // namespace atropos::experiments
