#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "experiments/commands.hpp"
#include "experiments/endoscope_view.hpp"
#include "experiments/exit_status.hpp"
#include "experiments/output_folder.hpp"
#include "experiments/progress_meter.hpp"
#include "experiments/sequence_writer.hpp"
#include "experiments/sha256.hpp"
#include "experiments/testbed.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
namespace {

struct GenerateOptions {
    std::string scene, output;
    int count = 1;
    int accel = 1;
    double time_scale = 1.0;
    CommonOptions common;
};

/// Ticks until frame k is due: frame times are multiples of the tick nearest to k / fps.
long ticks_of_frame(int k, double fps_hz) {
    return std::lround(1e3 * k / fps_hz);
}

/// One sequence; with `accel` A every A-th frame of it, renumbered, times and noise as in the base sequence.
void write_sequence(const scenes::SceneConfig& scene, int accel, const fs::path& folder,
                    ProgressMeter& meter) {
    Testbed testbed(scene);
    EndoscopeView endoscope(testbed);
    SequenceWriter writer(folder, testbed, {});
    const int frames = static_cast<int>(std::floor(scene.duration_s * scene.camera.fps_hz));
    long tick = 0;
    for (int k = 0; k < frames; k += accel) {
        for (; tick < ticks_of_frame(k, scene.camera.fps_hz); ++tick) testbed.tick();
        writer.add(testbed, endoscope.capture(testbed, k));
        meter.advance(accel);
    }
    writer.finish(testbed, {{"accel", accel}, {"renderer", endoscope.description()}});
}

int generate(const GenerateOptions& options) {
    check_output(options.output, options.common.force);
    std::vector<std::string> overrides = options.common.all_overrides();
    if (options.time_scale != 1.0) overrides.push_back(fmt::format("arms.time_scale={}", options.time_scale));
    const scenes::SceneConfig base = scenes::load_scene(options.scene, overrides);
    OutputFolder output(options.output, options.common.force);
    const auto frames = static_cast<long>(base.duration_s * base.camera.fps_hz);
    ProgressMeter meter("generate", frames * options.count, options.common.quiet);
    nlohmann::ordered_json dataset;
    dataset["name"] = base.name;
    dataset["count"] = options.count;
    dataset["accel"] = options.accel;
    for (int i = 0; i < options.count; ++i) {
        scenes::SceneConfig scene = base;
        if (options.count > 1) scene.seed = base.seed + static_cast<std::uint64_t>(i);
        const std::string name = fmt::format("sequence_{:06d}", i);
        write_sequence(scene, options.accel, output.path() / name, meter);
        dataset["sequences"].push_back({{"name", name},
                                        {"seed", scene.seed},
                                        {"sha256_meta", sha256_of_file(output.path() / name / "meta.json")}});
    }
    dataset["complete"] = true;
    write_file(output.path() / "dataset.json", dataset.dump(2) + "\n");
    output.commit();
    return kDone;
}

}  // namespace

void add_generate_command(CLI::App& program, Command& chosen) {
    CLI::App* app =
        program.add_subcommand("generate", "synthetic sequences with truth for every point of the thread");
    const auto options = std::make_shared<GenerateOptions>();
    app->add_option("SCENE", options->scene, "scene file")->required();
    app->add_option("-o,--output", options->output, "folder of the dataset")->required();
    app->add_option("--count", options->count, "sequences, with seeds in a row")
        ->check(CLI::Range(1, 1000000));
    app->add_option("--accel", options->accel, "write every A-th frame, as the paper's accelerations")
        ->check(CLI::Range(1, 1000));
    app->add_option("--time-scale", options->time_scale, "arms truly this much faster")
        ->check(CLI::Range(0.01, 20.0));
    add_common_options(*app, options->common);
    app->footer(
        "Example: atropos generate scenes/auto_scissors.yaml -o results/data --count 2 --set duration_s=2");
    app->callback([&chosen, options] { chosen = [options] { return generate(*options); }; });
}

}  // namespace atropos::experiments
