#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace atropos::experiments {

/// A JSON object from a file. Throws scenes::FileError when it can't be read or holds something else.
nlohmann::ordered_json read_json_object(const std::filesystem::path& file);

}  // namespace atropos::experiments
