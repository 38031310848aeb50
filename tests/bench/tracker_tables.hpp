#pragma once

#include <string>

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

}  // namespace atropos::bench
