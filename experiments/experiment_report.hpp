#pragma once

#include <filesystem>
#include <string>

#include "experiments/result_tables.hpp"

namespace atropos::experiments {

/// report.html of an experiment: one offline page with the tables, the plots there are, and the frames in
/// which the trackers were worst, each with the command that explains it.
void write_report(const ExperimentResults& results, const std::filesystem::path& folder);

}  // namespace atropos::experiments
