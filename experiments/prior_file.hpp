#pragma once

#include <filesystem>
#include <string>

#include "tracker/deformation_prior.hpp"

namespace atropos::experiments {

/// The text of a file of `atropos learn-prior`: JSON, version 1.
std::string to_json_text(const tracker::DeformationPrior& prior);

/// A prior from such a text; throws scenes::FileError that names `file` for anything else.
tracker::DeformationPrior parse_deformation_prior(const std::string& file, const std::string& text);

/// The same from a file.
tracker::DeformationPrior read_deformation_prior(const std::filesystem::path& file);

}  // namespace atropos::experiments
