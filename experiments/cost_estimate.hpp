#pragma once

#include <string>

#include "experiments/experiment_plan.hpp"

namespace atropos::experiments {

/// Processor seconds of one core and disk space, measured (docs/large_runs.md) for pictures of 640x360; all
/// but the start and the physics grow with the pixels.
struct CostRates {
    double start_s = 1.9;          ///< of a sequence: meshes, textures, the thread at rest
    double physics_s_per_s = 0.4;  ///< of simulated time
    double picture_s = 0.091;      ///< a stereo pair: drawn, developed, written
    double layers_s = 0.027;       ///< depth, mask and coverage of both eyes
    double track_s = 0.027;        ///< a stereo pair read and tracked by e1 or e2
    double refined_s = 0.038;      ///< by refined, which looks for the instruments too
    double pictures_mb = 0.73;
    double layers_mb = 0.32;
};
/// Seconds of one core and megabytes for a scene's frames as `generate` writes them.
struct GenerateCost {
    double core_s = 0.0;
    double megabytes = 0.0;
};
GenerateCost generate_cost(const scenes::SceneConfig& scene, int accel, bool layers);

/// A few lines for people: jobs, frames, core hours, hours with `processes` at a time, peak of disk space.
std::string describe_cost(const ExperimentPlan& plan, int processes);

}  // namespace atropos::experiments
