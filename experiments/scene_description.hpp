#pragma once

#include <string>

#include "scenes/scene_config.hpp"

namespace atropos::experiments {

/// What `atropos info` says of a scene's arms: base poses, reach, whether thread and cut are reachable, and
/// the recordings that drive them. Throws as the scene's set-up would.
std::string describe_arms(const scenes::SceneConfig& scene);

/// What `atropos info` says of its thread: derived physics, expected cost, warnings outside the range
/// checked.
std::string describe_thread(const scenes::SceneConfig& scene);

/// EI of the scene's thread from a bench measurement: `length_mm` of it clamped horizontally hangs down by
/// `sag_mm` at its free end.
std::string describe_sag(const scenes::SceneConfig& scene, double length_mm, double sag_mm);

}  // namespace atropos::experiments
