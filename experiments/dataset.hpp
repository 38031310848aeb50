#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scenes/scene_ranges.hpp"

namespace atropos::experiments {

/// train, val or test: 80, 10 and 10 % of all seeds, by a hash, so that a growing dataset keeps its splits.
std::string split_of_seed(std::uint64_t seed);

/// What dataset.json says of one sequence.
struct DatasetSequence {
    std::string name;
    std::uint64_t seed = 0;
    scenes::DrawnValues drawn;
};

/// dataset.json of the finished sequences in `folder`: counts, bytes, splits, checksums of each meta.json,
/// which holds those of all its files.
nlohmann::ordered_json describe_dataset(const std::filesystem::path& folder, const std::string& name,
                                        const std::vector<DatasetSequence>& sequences,
                                        const std::vector<std::string>& layers, int accel);

/// README.md of a dataset: what is in it, how to read it, where it differs from real pictures.
std::string dataset_card(const nlohmann::ordered_json& dataset);

/// Recomputes every checksum of a sequence, or of a dataset and all its sequences. Throws scenes::FileError
/// on the first file that is missing, new, or not what it was.
void verify_sequence(const std::filesystem::path& folder);
void verify_dataset(const std::filesystem::path& folder);

}  // namespace atropos::experiments
