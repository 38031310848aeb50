#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace atropos::experiments {

/// An experiment's folder as far as it has come: its manifest, and the results there are.
struct ExperimentResults {
    nlohmann::ordered_json manifest;
    std::map<std::string, nlohmann::ordered_json> by_job;

    std::size_t missing() const;
    std::size_t failed() const;
};

/// Reads experiment.json and jobs/*/result.json. Throws scenes::FileError on files that aren't what they
/// should be, such as one edited by hand.
ExperimentResults read_results(const std::filesystem::path& folder);

/// One combination of levels, over its seeds.
struct CellStatistics {
    struct Value {
        double mean = 0.0, std = 0.0, max = 0.0;  ///< over all frames of all seeds
    };
    std::map<std::string, std::string> levels;
    std::map<std::string, Value> metrics;
    std::map<std::string, int> verdicts;  ///< of closed loops
    std::map<std::string, int> reasons;   ///< of those aborted
    std::vector<double> cut_errors_mm;    ///< sizes, along the thread, of those cut; ascending
    int collisions = 0, attempts = 0;
    long frames = 0, lost_frames = 0, failed_frames = 0, silent_failures = 0;
    int seeds = 0, failed_jobs = 0, missing_jobs = 0;
};

std::vector<CellStatistics> statistics(const ExperimentResults& results);

/// Interval of a share, k of n, at 95 %: Wilson's score.
std::pair<double, double> wilson_interval(int k, int n);

}  // namespace atropos::experiments
