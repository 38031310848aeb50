#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <thread>

#include "experiments/commands.hpp"
#include "experiments/exit_status.hpp"
#include "experiments/external_tracker.hpp"
#include "experiments/output_folder.hpp"
#include "experiments/recorded_run.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace {

struct RunOptions {
    std::string scene, output;
    bool no_video = false, record = false;
    ExternalTrackerOptions external;
    CommonOptions common;
};

int run(const RunOptions& options) {
    check_output(options.output, options.common.force);
    scenes::SceneConfig scene = scenes::load_scene(options.scene, options.common.all_overrides());
    if (scene.arms.psm3.motion != "scissors")
        throw scenes::FileError(options.scene, "arms.PSM3.motion is " + scene.arms.psm3.motion +
                                                   ", expected scissors: a run closes the loop with them");
    scene.tracking.tracker.threads = options.common.threads;
    OutputFolder output(options.output, options.common.force);
    std::string log;
    RunRequest request;
    request.video = !options.no_video;
    request.record = options.record;
    request.quiet = options.common.quiet;
    const bool external = !options.external.command.empty();
    if (external)
        request.make_tracker = [&](const scenes::StereoRig& rig) {
            return make_external_tracker(options.external, rig, log, options.common.quiet);
        };
    const nlohmann::ordered_json summary = record_run(scene, output.path(), request);
    if (external) write_file(output.path() / "track" / "tracker.log", log);
    output.commit();
    const std::string verdict = summary["verdict"];
    fmt::print("{}: {}\n", verdict, summary["reason"].get<std::string>());
    return verdict == "cut" ? kDone : kNegative;
}

}  // namespace

void add_run_command(CLI::App& program, Command& chosen) {
    CLI::App* app = program.add_subcommand("run", "closed loop: simulates, renders, tracks, cuts, judges");
    const auto options = std::make_shared<RunOptions>();
    app->add_option("SCENE", options->scene, "scene file")->required();
    app->add_option("-o,--output", options->output, "folder of the run")->required();
    app->add_flag("--no-video", options->no_video, "without video.mp4");
    app->add_flag("--record", options->record,
                  "keeps what tracker and scissors were given and commanded, for `replay --inputs`");
    add_external_tracker_options(*app, options->external);
    options->common.threads = std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 2);
    add_common_options(*app, options->common);
    app->footer("Example: atropos run scenes/auto_scissors.yaml -o results/run --seed 7");
    app->callback([&chosen, options] { chosen = [options] { return run(*options); }; });
}

}  // namespace atropos::experiments
