#include <fmt/format.h>

#include <memory>

#include "experiments/commands.hpp"
#include "experiments/exit_status.hpp"
#include "experiments/folder_comparison.hpp"

namespace atropos::experiments {
namespace {

constexpr std::size_t kShownDifferences = 10;

struct CheckOptions {
    std::string baseline, result, tolerance;
};

int check(const CheckOptions& options) {
    const Tolerances tolerances =
        options.tolerance.empty() ? Tolerances{} : read_tolerances(options.tolerance);
    const std::vector<std::string> differences =
        compare_folders(options.baseline, options.result, tolerances, kShownDifferences);
    for (const std::string& difference : differences) fmt::print("{}\n", difference);
    if (differences.empty()) fmt::print("equal\n");
    return differences.empty() ? kDone : kNegative;
}

}  // namespace

void add_check_command(CLI::App& program, Command& chosen) {
    CLI::App* app =
        program.add_subcommand("check", "compares two result folders, first differences in words");
    const auto options = std::make_shared<CheckOptions>();
    app->add_option("BASELINE", options->baseline, "folder of a track, run, experiment or dataset")
        ->required();
    app->add_option("RESULT", options->result, "folder to compare with it")->required();
    app->add_option("--tolerance", options->tolerance,
                    "tolerance file (docs/experiments.md); without one: bytes")
        ->type_name("FILE");
    app->footer("Example: atropos check results/baseline results/track --tolerance tolerance.yaml");
    app->callback([&chosen, options] { chosen = [options] { return check(*options); }; });
}

}  // namespace atropos::experiments
