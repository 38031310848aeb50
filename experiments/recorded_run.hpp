#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "experiments/scissors_pilot.hpp"
#include "scenes/scene_config.hpp"

namespace atropos::experiments {

/// What to keep of a run beside what every run writes.
struct RunRequest {
    bool video = true;
    bool record = false;        ///< what the pilot was given and commanded (loop_recording.hpp)
    bool quiet = false;         ///< no progress on stderr
    TrackerMaker make_tracker;  ///< null: the scene's own
};

/// Runs a scene's closed loop and writes its folder (design: "Run"); returns summary.json.
nlohmann::ordered_json record_run(const scenes::SceneConfig& scene, const std::filesystem::path& folder,
                                  const RunRequest& request);

}  // namespace atropos::experiments
