#include "experiments/commands.hpp"

#include "experiments/external_tracker.hpp"

namespace atropos::experiments {

std::vector<std::string> CommonOptions::all_overrides() const {
    std::vector<std::string> all = overrides;
    if (seed) all.push_back("seed=" + std::to_string(*seed));
    return all;
}

void add_common_options(CLI::App& app, CommonOptions& common) {
    app.add_option("--seed", common.seed, "seed of every random stream");
    app.add_option("--set", common.overrides, "override a scene key: key.path=value (repeatable)")
        ->take_all()
        ->expected(1)
        ->type_name("KEY=VALUE");
    app.add_option("--threads", common.threads, "threads; results do not depend on it")
        ->check(CLI::Range(1, 256));
    app.add_flag("--quiet", common.quiet, "no progress on stderr");
    app.add_flag("--force", common.force, "replace a non-empty output folder");
}

void add_external_tracker_options(CLI::App& app, ExternalTrackerOptions& options) {
    app.add_option("--tracker", options.command,
                   "a shell command that tracks in place of ours (docs/own_tracker.md)")
        ->type_name("CMD");
    app.add_option("--tracker-timeout", options.timeout_s, "seconds it may take for a frame")
        ->check(CLI::Range(0.01, 3600.0))
        ->type_name("S");
}

}  // namespace atropos::experiments
