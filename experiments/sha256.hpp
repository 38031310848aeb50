#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace atropos::experiments {

/// FIPS 180-4 SHA-256, in lower-case hexadecimal.
std::string sha256(std::string_view bytes);

/// Of a file's bytes; throws scenes::FileError when it can't be read.
std::string sha256_of_file(const std::filesystem::path& file);

}  // namespace atropos::experiments
