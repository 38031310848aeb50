#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scenes/scene_config.hpp"
#include "scenes/stereo_rig.hpp"

namespace atropos::scenes {

/// Reads a scene file, its `include`s first, then the overrides "key.path=value" in their order. Unknown
/// keys, wrong types, values out of range, missing files and include loops throw FileError with file and
/// line.
SceneConfig load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

/// As `load_scene` on a text; paths in it are relative to `base`.
SceneConfig parse_scene(const std::string& name, const std::string& text, const std::filesystem::path& base,
                        const std::vector<std::string>& overrides = {});

/// The fully resolved scene as a YAML text that reads back equal.
std::string to_yaml(const SceneConfig& scene);

/// docs/scene.md, from the loader's own table.
std::string scene_reference_markdown();

/// The scene's rig: its calibration file or preset, scaled to the wanted size. Throws FileError or
/// std::invalid_argument.
StereoRig scene_rig(const CameraConfig& camera);

/// `name` next to the file that names it, else in the share folders (installed, then the source tree); as it
/// is when found nowhere.
std::filesystem::path resolve_path(const std::filesystem::path& base, const std::string& name);

}  // namespace atropos::scenes
