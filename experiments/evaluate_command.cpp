#include <fmt/format.h>

#include <memory>

#include "experiments/commands.hpp"
#include "experiments/csv_file.hpp"
#include "experiments/exit_status.hpp"
#include "experiments/metrics.hpp"
#include "experiments/output_folder.hpp"
#include "experiments/sequence_bound.hpp"
#include "experiments/track_reader.hpp"
#include "scenes/calibration_file.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using scenes::FileError;
namespace {

struct EvaluateOptions {
    std::string sequence, track, per_frame;
    bool json = false, bound = false;
};

/// What the pictures allow, beside what was reached: the bound, the ratio, and what the bound assumes.
void add_bound(const std::string& folder, const std::vector<TruthFrame>& truth,
               nlohmann::ordered_json& summary) {
    const fs::path scene = fs::path(folder) / "scene.yaml";
    const scenes::SceneConfig settings =
        fs::exists(scene) ? scenes::load_scene(scene, {}) : scenes::SceneConfig{};
    const SequenceBound bound = sequence_bound(Sequence::open(folder), truth, settings.tracking.tracker);
    summary["bound_3d_mm"] = statistics(bound.mean_3d_mm);
    if (summary["accuracy_3d_mm"].is_object())
        summary["accuracy_over_bound"] =
            summary["accuracy_3d_mm"]["mean"].get<double>() / summary["bound_3d_mm"]["mean"].get<double>();
    summary.update(bound.assumed);
}

int evaluate(const EvaluateOptions& options) {
    const scenes::StereoRig rig =
        scenes::load_calibration(fs::path(options.sequence) / "calib" / "stereo.yaml");
    const std::vector<TrackedFrame> track = read_track(options.track);
    const int last = track.empty() ? 0 : track.back().frame;
    const std::vector<TruthFrame> truth = read_truth(options.sequence, last + 1);
    std::vector<EvaluatedFrame> frames;
    for (const TrackedFrame& tracked : track) {
        const scenes::Polyline& span = truth[static_cast<size_t>(tracked.frame)].span_C;
        if (span.points.size() < 2) continue;  // nothing to judge, such as after the cut
        EvaluatedFrame f{tracked.frame, tracked.estimate.status, tracked.estimate.samples.size() >= 2, {}};
        if (f.has_curve) f.metrics = compare(tracked.estimate, span, rig);
        frames.push_back(f);
    }
    if (frames.empty())
        throw FileError(options.sequence,
                        "no frame with a true span, expected truth/thread.csv to cover the track");
    nlohmann::ordered_json summary = summarise(frames);
    if (options.bound) add_bound(options.sequence, truth, summary);
    if (!options.per_frame.empty()) write_file(options.per_frame, per_frame_csv(frames));
    if (options.json)
        fmt::print("{}\n", summary.dump(2));
    else
        fmt::print("{}", summary_table(summary));
    return kDone;
}

}  // namespace

void add_evaluate_command(CLI::App& program, Command& chosen) {
    CLI::App* app = program.add_subcommand("evaluate", "measures a track against a sequence's truth");
    const auto options = std::make_shared<EvaluateOptions>();
    app->add_option("SEQUENCE", options->sequence, "folder with calib/stereo.yaml and truth/thread.csv")
        ->required();
    app->add_option("TRACK", options->track, "track folder, or a bare track.csv of any number of samples")
        ->required();
    app->add_flag("--json", options->json, "the summary as JSON");
    app->add_option("--per-frame", options->per_frame,
                    "also write the metrics of each frame to this CSV file");
    app->add_flag("--bound", options->bound,
                  "what the pictures allow besides: the Bayesian Cramer-Rao bound and what it assumes");
    app->footer("Example: atropos evaluate results/data/sequence_000000 results/track");
    app->callback([&chosen, options] { chosen = [options] { return evaluate(*options); }; });
}

}  // namespace atropos::experiments
