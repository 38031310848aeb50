#pragma once

#include <filesystem>

#include "scenes/scene_config.hpp"

namespace atropos::experiments {

/// The paper's synthetic sequence (III-A; protocol P): the scene is simulated, drawn and tracked with e2 (K =
/// 8, ends exact, labels half as wide as Table I's); the spline of each frame, with its jitter, is the truth
/// of a second sequence that shows it over the tissue, without arms. Writes that sequence: pictures,
/// calibration, frames.csv, exact tips.csv, truth/thread.csv.
void make_reprojected_sequence(const scenes::SceneConfig& scene, const std::filesystem::path& folder);

}  // namespace atropos::experiments
