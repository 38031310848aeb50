#pragma once

#include <string>
#include <vector>

#include "tests/bench/refined_run.hpp"

namespace atropos::bench {

/// Each prints Markdown and returns 0 when every bound of it is met, 1 otherwise. `folder` keeps what is
/// done.
int print_paper_table(const std::string& camera, const std::string& folder, int frames);
int print_rig_table(const std::string& folder, int frames, int seeds);
int print_start_table(int curves);

/// One choice changed at a time; always returns 0.
int print_ablation_table(int frames);

/// The offsets that 68 % of the samples keep within on the seeds for tuning; always returns 0.
int print_sigma_table(const std::string& camera, const std::string& folder, int frames);

/// Means over a grid of label spacings and weights; always returns 0.
int print_tuning(const std::string& camera, int frames);

/// The refined tracker on the rows whose names begin with `wanted` (empty: all).
int print_refined_table(int frames, const SeedRange& seeds, const std::string& wanted);

/// The same with one term changed at a time, and the paper's trackers; always returns 0.
int print_refined_ablation(int frames, const SeedRange& seeds, const std::string& wanted);

/// Hard rows as the tracker is, with learned priors (of drawn sequences and of `files`), and with a rod that
/// predicts; always returns 0.
int print_prior_table(int frames, const SeedRange& seeds, const std::string& wanted,
                      const std::vector<std::string>& files);

/// One line for each frame of the refined tracker; always returns 0.
int print_refined_frames(int frames, const SeedRange& seeds, const std::string& wanted);

/// Writes the ten worst frames of each row to `folder`, truth green under the estimate in red, twice the
/// size; always returns 0.
int draw_worst_frames(const std::string& folder, int frames, const SeedRange& seeds,
                      const std::string& wanted);

struct LoopTableOptions {
    int sequences = 200;
    int frames = 120;
    std::uint64_t first_seed = 1;
    bool verbose = false;
};

/// Generated threads that cross themselves: order right by the discrete Frechet distance in both eyes.
int print_loop_table(const LoopTableOptions& options);

}  // namespace atropos::bench
