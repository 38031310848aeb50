#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace atropos::scenes {

/// One draw of everything that a scene file leaves to chance: key path and value, as in "key.path=value".
using DrawnValues = std::vector<std::pair<std::string, std::string>>;

/// Draws the section `randomise` of a scene file (its `include`s first): `key.path: [low, high]` uniform, or
/// `{log: [low, high]}`, `{whole: [low, high]}`, `{choice: [a, b, ...]}`. Each key has a random stream of its
/// own, so that adding one changes no other. Empty when the file has no such section. Throws FileError with
/// the line.
DrawnValues draw_randomised(const std::filesystem::path& file, std::uint64_t seed);

}  // namespace atropos::scenes
