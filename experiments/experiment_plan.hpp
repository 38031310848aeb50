#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "experiments/degradation.hpp"
#include "scenes/scene_config.hpp"

namespace atropos::experiments {

/// One job of an experiment: everything its result depends on besides the program.
struct JobSpec {
    enum class Kind {
        kTrack,  ///< a generated sequence, tracked and judged
        kRun,    ///< the closed loop
    };
    Kind kind = Kind::kTrack;
    scenes::SceneConfig scene;
    bool reprojected = false;  ///< track: protocol P, the spline of a first track shown and judged
    int accel = 1;             ///< track: every A-th frame of the sequence
    Degradation degradation;   ///< track: of the pictures, ends and calibration that the tracker gets
    std::string command;       ///< an external tracker in place of the scene's method
    std::string id;            ///< hash of all the above
    std::string sequence_id;   ///< hash of what the sequence alone depends on; track jobs share it
};

/// Where a job stands in the tables: the level of each factor, and the seed. Cells may share a job.
struct Cell {
    std::map<std::string, std::string> levels;
    std::uint64_t seed = 0;
    std::size_t job = 0;  ///< index into ExperimentPlan::jobs
};

/// What the tables show: rows and columns are factors; every other factor gives tables of its own.
struct TableSpec {
    std::string rows, columns;
    std::vector<std::string> metrics;
};

/// A published figure to stand beside ours.
struct PublishedFigure {
    std::map<std::string, std::string> levels;
    std::string metric;
    double mean = 0.0, std = 0.0;
};

/// An experiment file, expanded (docs/experiments.md): base scene, alternatives, trackers, seeds.
struct ExperimentPlan {
    std::string name, title;
    std::vector<std::pair<std::string, std::vector<std::string>>> factors;  ///< with their levels, in order
    std::vector<JobSpec> jobs;  ///< each once; those that share a sequence stand together
    std::vector<Cell> cells;
    TableSpec table;
    std::vector<PublishedFigure> published;
    double timeout_s = 3600.0;  ///< of a job
    int seeds = 0;

    /// Every job and cell as JSON text: what tells one experiment from another.
    std::string manifest() const;
};

/// Reads and expands an experiment file, overrides on top of every job. Throws scenes::FileError, with the
/// line, for unknown keys, settings that no scene has, and levels that say nothing.
ExperimentPlan load_experiment(const std::filesystem::path& file, const std::vector<std::string>& overrides);

}  // namespace atropos::experiments
