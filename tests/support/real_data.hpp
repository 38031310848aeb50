#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>

namespace atropos::support {

/// A file of the folder that ATROPOS_DATA names; nothing when it is not set, so that a test may skip. Throws
/// std::runtime_error when the folder is named and hasn't got the file: that is no reason to skip.
inline std::optional<std::filesystem::path> real_data(const std::string& name) {
    const char* folder = std::getenv("ATROPOS_DATA");
    if (!folder) return std::nullopt;
    std::filesystem::path file = std::filesystem::path(folder) / name;
    if (!std::filesystem::exists(file))
        throw std::runtime_error(file.string() + ": missing, expected in the folder of ATROPOS_DATA");
    return file;
}

inline constexpr const char* kNoRealData =
    "ATROPOS_DATA is not set: real recordings are not in the repository";

}  // namespace atropos::support
