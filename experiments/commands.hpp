#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace atropos::experiments {

/// Options that most commands share.
struct CommonOptions {
    std::optional<std::uint64_t> seed;
    std::vector<std::string> overrides;  ///< --set key.path=value
    int threads = 1;
    bool quiet = false;
    bool force = false;

    /// The overrides with --seed appended as one of them.
    std::vector<std::string> all_overrides() const;
};

/// A command ends with an exit status; it throws scenes::FileError on bad input.
using Command = std::function<int()>;

/// Adds --seed, --set, --threads, --quiet, --force.
void add_common_options(CLI::App& app, CommonOptions& common);

struct ExternalTrackerOptions;

/// Adds --tracker, --tracker-timeout.
void add_external_tracker_options(CLI::App& app, ExternalTrackerOptions& options);

void add_run_command(CLI::App& program, Command& chosen);
void add_generate_command(CLI::App& program, Command& chosen);
void add_render_command(CLI::App& program, Command& chosen);
void add_info_command(CLI::App& program, Command& chosen);
void add_track_command(CLI::App& program, Command& chosen);
void add_evaluate_command(CLI::App& program, Command& chosen);
void add_experiment_command(CLI::App& program, Command& chosen);
void add_merge_command(CLI::App& program, Command& chosen);
void add_check_command(CLI::App& program, Command& chosen);
void add_replay_command(CLI::App& program, Command& chosen);
void add_report_command(CLI::App& program, Command& chosen);
void add_figure_command(CLI::App& program, Command& chosen);
void add_learn_prior_command(CLI::App& program, Command& chosen);
void add_import_command(CLI::App& program, Command& chosen);

}  // namespace atropos::experiments
