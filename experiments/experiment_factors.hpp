#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "experiments/experiment_plan.hpp"

namespace atropos::experiments {

/// What a level of a factor changes.
struct Settings {
    std::vector<std::string> overrides;  ///< key.path=value
    int accel = 0;                       ///< 0: not said
    std::vector<std::pair<std::string, double>> degradation;
    std::string protocol;  ///< P, S, or empty: not said
    std::string command;
};

struct Level {
    std::string name;
    Settings settings;
};

struct Factor {
    std::string name;
    std::vector<Level> levels;
};

/// One of the list's alternatives: levels of one or more factors at once.
struct Alternative {
    std::vector<std::pair<std::string, std::string>> levels;
    Settings settings;
};

/// Adds what a further level says; where both speak, `more` does.
void append(Settings& to, const Settings& more);

/// An experiment file as it is written: what is tried, not yet multiplied out.
struct ExperimentFactors {
    std::filesystem::path file, scene_file;
    JobSpec::Kind kind = JobSpec::Kind::kTrack;
    Settings base;
    std::vector<Factor> grid;
    std::vector<Alternative> list;
    std::vector<std::uint64_t> seeds;
    std::vector<std::string> overrides;  ///< of the command line, on top of every job
};

constexpr std::size_t kMaxCells = 1'000'000;

/// Fills `plan` with a cell for every alternative, seed and combination of levels, and with the jobs they
/// need. Throws scenes::FileError for more than kMaxCells.
void expand(const ExperimentFactors& factors, ExperimentPlan& plan);

}  // namespace atropos::experiments
