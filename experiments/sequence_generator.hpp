#pragma once

#include <filesystem>
#include <functional>

#include "experiments/sequence_writer.hpp"
#include "scenes/scene_config.hpp"

namespace atropos::experiments {

/// Frames that a scene's sequence has before acceleration.
int frames_of(const scenes::SceneConfig& scene);

/// Simulates and draws one sequence into `folder`: every `accel`-th frame of it, renumbered, times and noise
/// as in the base sequence. `advance` is called after each frame with the base frames passed; `extra` goes
/// into meta.json.
void generate_sequence(const scenes::SceneConfig& scene, int accel, const std::filesystem::path& folder,
                       const SequenceLayers& layers, const std::function<void(int)>& advance,
                       const nlohmann::ordered_json& extra = nlohmann::ordered_json::object());

}  // namespace atropos::experiments
