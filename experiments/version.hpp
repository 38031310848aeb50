#pragma once

#include <string>

namespace atropos::experiments {

/// "0.1.0".
std::string version_number();

/// Version, build type and compiler, for --version and meta.json.
std::string version_text();

}  // namespace atropos::experiments
