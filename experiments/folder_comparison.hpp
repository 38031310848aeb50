#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace atropos::experiments {

/// By how much a number may differ: |a - b| <= absolute + relative |a|, a being the baseline's.
struct ToleranceRule {
    std::string file = "*";  ///< shell pattern of the path below the folder
    std::string key = "*";   ///< of the CSV column, or of the JSON key with its path: metrics.tip_mm.mean
    double absolute = 0.0;
    double relative = 0.0;
};

struct Tolerances {
    std::vector<std::string> ignored = {"timing.json", "*/timing.json"};  ///< shell patterns of files
    std::vector<ToleranceRule> rules;                                     ///< the last that fits holds
};

/// Reads a tolerance file: `ignore: [PATTERN]`, `rules: [{file, key, absolute, relative}]`. Throws
/// scenes::FileError.
Tolerances read_tolerances(const std::filesystem::path& file);

/// Every difference between two folders in words, at most `limit`, then how many more there are: files that
/// one lacks, numbers of CSV and JSON files beyond their tolerance, and bytes of all others. Empty: equal.
std::vector<std::string> compare_folders(const std::filesystem::path& baseline,
                                         const std::filesystem::path& result, const Tolerances& tolerances,
                                         std::size_t limit);

}  // namespace atropos::experiments
