#include "experiments/cost_estimate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "experiments/sequence_generator.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace {

/// Pixels over those of 640x360.
double size_factor(const scenes::SceneConfig& scene) {
    const scenes::StereoRig rig = scenes::scene_rig(scene.camera);
    return static_cast<double>(rig.left.width_px) * rig.left.height_px / (640.0 * 360.0);
}

constexpr CostRates kRates;

}  // namespace

GenerateCost generate_cost(const scenes::SceneConfig& scene, int accel, bool layers) {
    const double frames = std::ceil(static_cast<double>(frames_of(scene)) / accel) * size_factor(scene);
    return {kRates.start_s + scene.duration_s * kRates.physics_s_per_s +
                frames * (kRates.picture_s + (layers ? kRates.layers_s : 0.0)),
            frames * (kRates.pictures_mb + (layers ? kRates.layers_mb : 0.0))};
}

std::string describe_cost(const ExperimentPlan& plan, int processes) {
    std::set<std::string> sequences;
    double core_s = 0.0, largest_mb = 0.0;
    long tracked = 0;
    for (const JobSpec& job : plan.jobs) {
        const bool is_new = job.kind == JobSpec::Kind::kTrack && sequences.insert(job.sequence_id).second;
        const GenerateCost sequence = generate_cost(job.scene, 1, false);
        if (is_new) {
            core_s += sequence.core_s;
            largest_mb = std::max(largest_mb, sequence.megabytes);
        }
        const int frames = (frames_of(job.scene) + job.accel - 1) / job.accel;
        tracked += frames;
        const bool refined = job.scene.tracking.tracker.method == scenes::TrackerMethod::kRefined;
        core_s += frames * (refined ? kRates.refined_s : kRates.track_s) * size_factor(job.scene);
        if (job.kind == JobSpec::Kind::kRun) core_s += sequence.core_s;
    }
    return fmt::format(
        "{}: {} jobs in {} cells, {} sequences, {} seeds\n"
        "{} frames to track\n"
        "{:.2f} core hours by the rates of docs/large_runs.md; {:.2f} h with {} at a time\n"
        "{:.2f} GB at most while it runs (one sequence a process), some MB when done\n",
        plan.name, plan.jobs.size(), plan.cells.size(), sequences.size(), plan.seeds, tracked,
        core_s / 3600.0, core_s / 3600.0 / processes, processes, 1e-3 * largest_mb * processes);
}

}  // namespace atropos::experiments
