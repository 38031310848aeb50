#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <memory>

#include "experiments/commands.hpp"
#include "experiments/exit_status.hpp"
#include "experiments/experiment_report.hpp"
#include "experiments/output_folder.hpp"
#include "experiments/recorded_run.hpp"
#include "experiments/result_tables.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
namespace {

/// Tables, plots and page of an experiment as far as it has come.
void report_experiment(const fs::path& folder) {
    const ExperimentResults results = read_results(folder);
    write_tables(results, folder);
    write_report(results, folder);
    fmt::print("{}: {} jobs done, {} missing, {} failed\n", (folder / "report.html").string(),
               results.by_job.size(), results.missing(), results.failed());
}

/// A run keeps no pictures: they are drawn again, from the same scene to the same bytes.
void report_run(const fs::path& folder, bool quiet) {
    if (fs::exists(folder / "track" / "tracker.log"))
        throw scenes::FileError((folder / "track" / "tracker.log").string(),
                                "another program tracked, expected a run of our own trackers");
    OutputFolder again(folder / fmt::format("report-{}", ::getpid()), true);
    RunRequest request;
    request.video = false;
    request.quiet = quiet;
    record_run(scenes::load_scene(folder / "scene.yaml"), again.path(), request);
    fs::rename(again.path() / "report.html", folder / "report.html");
    fmt::print("{}\n", (folder / "report.html").string());
}

void report(const fs::path& folder, bool quiet) {
    if (fs::exists(folder / "experiment.json"))
        report_experiment(folder);
    else if (fs::exists(folder / "summary.json"))
        report_run(folder, quiet);
    else
        throw scenes::FileError(folder.string(),
                                "has neither summary.json nor experiment.json, expected the folder of a "
                                "finished run or of an experiment");
}

}  // namespace

void add_report_command(CLI::App& program, Command& chosen) {
    CLI::App* app =
        program.add_subcommand("report", "one self-contained offline page of a run or an experiment");
    const auto folder = std::make_shared<std::string>();
    const auto quiet = std::make_shared<bool>(false);
    app->add_option("DIR", *folder, "folder of a run or an experiment, finished or not")->required();
    app->add_flag("-q,--quiet", *quiet, "no progress");
    app->footer("Example: atropos report results/table1");
    app->callback([&chosen, folder, quiet] {
        chosen = [folder, quiet] {
            report(*folder, *quiet);
            return kDone;
        };
    });
}

}  // namespace atropos::experiments
