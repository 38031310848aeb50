#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>

#include "experiments/commands.hpp"
#include "experiments/exit_status.hpp"
#include "experiments/folder_comparison.hpp"
#include "experiments/loop_recording.hpp"
#include "experiments/output_folder.hpp"
#include "experiments/recorded_run.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kShownDifferences = 10;

struct ReplayOptions {
    std::string folder;
    bool inputs = false, quiet = false;
};

std::string bytes_of(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) throw scenes::FileError(file.string(), "can't be read, expected a file of `run --record`");
    return {std::istreambuf_iterator<char>(stream), {}};
}

/// The line in which two texts differ first, from 1; 0: none.
std::size_t first_difference(const std::string& a, const std::string& b) {
    if (a == b) return 0;
    const auto place = std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first;
    return 1 + static_cast<std::size_t>(std::count(a.begin(), place, '\n'));
}

/// Tracker and scissors once more on the pictures and poses they were given.
int replay_from_inputs(const ReplayOptions& options) {
    const std::string recorded = bytes_of(fs::path(options.folder) / "inputs" / "commands.csv");
    const std::size_t line = first_difference(recorded, replay_inputs(options.folder));
    if (line == 0)
        fmt::print("equal: {} commands from pictures and measured poses alone\n",
                   std::count(recorded.begin(), recorded.end(), '\n') - 1);
    else
        fmt::print("inputs/commands.csv: the commands differ from line {} on\n", line);
    return line == 0 ? kDone : kNegative;
}

/// The whole episode once more, simulation included.
int replay_run(const ReplayOptions& options) {
    const fs::path run = options.folder;
    if (!fs::exists(run / "summary.json"))
        throw scenes::FileError(options.folder, "has no summary.json, expected the folder of a finished run");
    if (fs::exists(run / "track" / "tracker.log"))
        throw scenes::FileError((run / "track" / "tracker.log").string(),
                                "another program tracked, expected a run of our own trackers");
    const fs::path again = fs::temp_directory_path() / fmt::format("atropos-replay-{}", ::getpid());
    OutputFolder output(again, true);
    RunRequest request;
    request.video = fs::exists(run / "video.mp4");
    request.record = fs::exists(run / "inputs");
    request.quiet = options.quiet;
    record_run(scenes::load_scene(run / "scene.yaml"), output.path(), request);
    const auto differences = compare_folders(run, output.path(), Tolerances{}, kShownDifferences);
    for (const std::string& difference : differences) fmt::print("{}\n", difference);
    if (differences.empty()) fmt::print("equal\n");
    return differences.empty() ? kDone : kNegative;
}

}  // namespace

void add_replay_command(CLI::App& program, Command& chosen) {
    CLI::App* app = program.add_subcommand("replay", "runs a finished run again and compares bytes");
    const auto options = std::make_shared<ReplayOptions>();
    app->add_option("DIR", options->folder, "folder of a run")->required();
    app->add_flag("--inputs", options->inputs,
                  "tracker and scissors only, on what `run --record` kept: truth is not needed");
    app->add_flag("-q,--quiet", options->quiet, "no progress");
    app->footer("Example: atropos replay results/run");
    app->callback([&chosen, options] {
        chosen = [options] { return options->inputs ? replay_from_inputs(*options) : replay_run(*options); };
    });
}

}  // namespace atropos::experiments
