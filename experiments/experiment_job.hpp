#pragma once

#include <filesystem>

#include "experiments/experiment_plan.hpp"

namespace atropos::experiments {

/// What of a job stays on disk besides its results: tracks, and the sequences that they were made from.
enum class Keep { kNone, kFailures, kAll };

/// Generates the pictures that the job's tracker sees, and the truth, into `folder`.
void make_sequence(const JobSpec& job, const std::filesystem::path& folder);

/// Does a job into `folder`: scene.yaml, result.json, frames.csv (metrics of each frame), timing.json, and
/// the track or run itself as `keep` says: a failure is a frame that failed, or a verdict other than cut.
/// `sequence` is used by track jobs only.
void do_job(const JobSpec& job, const std::filesystem::path& sequence, const std::filesystem::path& folder,
            Keep keep);

/// The folder of a job that came to nothing.
void write_failure(const JobSpec& job, const std::string& reason, const std::filesystem::path& folder);

}  // namespace atropos::experiments
