#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "experiments/coco_export.hpp"
#include "experiments/commands.hpp"
#include "experiments/cost_estimate.hpp"
#include "experiments/dataset.hpp"
#include "experiments/exit_status.hpp"
#include "experiments/output_folder.hpp"
#include "experiments/progress_meter.hpp"
#include "experiments/python_files.hpp"
#include "experiments/sequence_generator.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"
#include "scenes/text_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using scenes::FileError;
namespace {

struct GenerateOptions {
    std::string scene, output;
    int count = 1;
    int accel = 1;
    double time_scale = 1.0;
    std::vector<std::string> layers = {"depth", "mask", "coverage"};
    bool rectified = false, coco = false, resume = false;
    CommonOptions common;
};

struct PlannedSequence {
    DatasetSequence entry;
    scenes::SceneConfig scene;
};

/// Every sequence's scene: seeds in a row, what the file leaves to chance drawn, the command line's word
/// last.
std::vector<PlannedSequence> plan(const GenerateOptions& options) {
    std::vector<std::string> overrides = options.common.all_overrides();
    if (options.time_scale != 1.0) overrides.push_back(fmt::format("arms.time_scale={}", options.time_scale));
    const std::uint64_t seed = scenes::load_scene(options.scene, overrides).seed;
    std::vector<PlannedSequence> sequences;
    for (int i = 0; i < options.count; ++i) {
        const std::uint64_t own_seed = seed + static_cast<std::uint64_t>(i);
        scenes::DrawnValues drawn = scenes::draw_randomised(options.scene, own_seed);
        std::vector<std::string> all;
        for (const auto& [key, value] : drawn) all.push_back(key + "=" + value);
        all.insert(all.end(), overrides.begin(), overrides.end());
        all.push_back(fmt::format("seed={}", own_seed));
        sequences.push_back({{fmt::format("sequence_{:06d}", i), own_seed, std::move(drawn)},
                             scenes::load_scene(options.scene, all)});
    }
    return sequences;
}

SequenceLayers layers_of(const GenerateOptions& options) {
    const auto has = [&](const char* name) {
        return std::find(options.layers.begin(), options.layers.end(), name) != options.layers.end();
    };
    return {has("depth"), has("mask"), has("coverage"), options.rectified};
}

std::vector<std::string> layer_names(const SequenceLayers& layers) {
    std::vector<std::string> names;
    if (layers.depth) names.emplace_back("depth");
    if (layers.mask) names.emplace_back("mask");
    if (layers.coverage) names.emplace_back("coverage");
    if (layers.rectified) names.emplace_back("rectified");
    return names;
}

void say_cost(const std::vector<PlannedSequence>& sequences, const GenerateOptions& options) {
    GenerateCost cost;
    long frames = 0;
    for (const PlannedSequence& s : sequences) {
        const GenerateCost one = generate_cost(s.scene, options.accel, !options.layers.empty());
        cost.core_s += one.core_s;
        cost.megabytes += one.megabytes;
        frames += (frames_of(s.scene) + options.accel - 1) / options.accel;
    }
    fmt::print(stderr, "{} sequences, {} stereo frames: about {:.0f} MB and {:.1f} core minutes\n",
               sequences.size(), frames, cost.megabytes, cost.core_s / 60.0);
}

/// Whether the sequence is there from an interrupted run. Throws when it is another one.
bool is_done(const fs::path& folder, const PlannedSequence& sequence, const GenerateOptions& options) {
    if (!fs::exists(folder / "meta.json")) return false;
    const auto meta = nlohmann::json::parse(
        scenes::read_text_file(folder / "meta.json", std::size_t{1} << 30), nullptr, false);
    const bool same =
        scenes::read_text_file(folder / "scene.yaml", 4 << 20) == scenes::to_yaml(sequence.scene) &&
        meta.is_object() && meta.value("accel", 0) == options.accel &&
        meta.value("layers", std::vector<std::string>{}) == layer_names(layers_of(options));
    if (!same)
        throw FileError(folder.string(),
                        "is of another scene or other layers, expected the same command or no --resume");
    return true;
}

void write_one(const PlannedSequence& sequence, const fs::path& folder, const GenerateOptions& options,
               ProgressMeter& meter) {
    OutputFolder place(folder, true);
    nlohmann::ordered_json drawn = nlohmann::ordered_json::object();
    for (const auto& [key, value] : sequence.entry.drawn) drawn[key] = value;
    generate_sequence(sequence.scene, options.accel, place.path(), layers_of(options),
                      [&](int frames) { meter.advance(frames); },
                      {{"layers", layer_names(layers_of(options))}, {"drawn", drawn}});
    place.commit();
}

/// Whether an earlier run has come to its end. Throws when it was of another command.
bool is_whole(const std::vector<PlannedSequence>& sequences, const GenerateOptions& options) {
    if (!fs::exists(fs::path(options.output) / "dataset.json")) return false;
    return std::all_of(sequences.begin(), sequences.end(), [&](const PlannedSequence& sequence) {
        return is_done(fs::path(options.output) / sequence.entry.name, sequence, options);
    });
}

int generate(const GenerateOptions& options) {
    const std::vector<PlannedSequence> sequences = plan(options);
    if (options.resume && is_whole(sequences, options)) return kDone;
    check_output(options.output, options.common.force);
    if (!options.common.quiet) say_cost(sequences, options);
    OutputFolder output(
        options.output, options.common.force,
        options.resume ? OutputFolder::Leftover::kContinue : OutputFolder::Leftover::kKeepOnFailure);
    long frames = 0;
    for (const PlannedSequence& s : sequences) frames += frames_of(s.scene);
    ProgressMeter meter("generate", frames, options.common.quiet);
    std::vector<DatasetSequence> entries;
    std::vector<std::string> names;
    for (const PlannedSequence& s : sequences) {
        const fs::path folder = output.path() / s.entry.name;
        if (is_done(folder, s, options))
            meter.advance(frames_of(s.scene));
        else
            write_one(s, folder, options, meter);
        entries.push_back(s.entry);
        names.push_back(s.entry.name);
    }
    const auto dataset = describe_dataset(output.path(), sequences.front().scene.name, entries,
                                          layer_names(layers_of(options)), options.accel);
    if (options.coco)
        write_file(output.path() / "coco.json", coco_annotations(output.path(), names).dump() + "\n");
    write_file(output.path() / "README.md", dataset_card(dataset));
    write_file(output.path() / "atropos_numpy.py", kAtroposNumpyPy);
    write_file(output.path() / "atropos_torch.py", kAtroposTorchPy);
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
    app->add_option("--layers", options->layers,
                    "depth, mask, coverage; none: pictures and the thread's curve alone")
        ->delimiter(',')
        ->check(CLI::IsMember({"depth", "mask", "coverage", "none"}));
    app->add_flag("--rectified", options->rectified,
                  "rectified pairs, disparity and occlusion of both eyes besides");
    app->add_flag("--coco", options->coco, "coco.json: masks and key points of the left pictures");
    app->add_flag("--resume", options->resume, "go on where an interrupted run stopped");
    add_common_options(*app, options->common);
    app->footer(
        "Example: atropos generate scenes/auto_scissors.yaml -o results/data --count 2 --set duration_s=2");
    app->callback([&chosen, options] {
        chosen = [options] {
            if (options->layers == std::vector<std::string>{"none"}) options->layers.clear();
            return generate(*options);
        };
    });
}

}  // namespace atropos::experiments
