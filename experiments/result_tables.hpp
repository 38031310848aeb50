#pragma once

#include <filesystem>
#include <string>

#include "experiments/result_statistics.hpp"

namespace atropos::experiments {

/// tables/ (cells.csv, NAME.md, NAME.tex) and plots/ (data, gnuplot script, and the picture where gnuplot is
/// installed), whole or unfinished.
void write_tables(const ExperimentResults& results, const std::filesystem::path& folder);

/// The tables as Markdown.
std::string markdown_tables(const ExperimentResults& results);

}  // namespace atropos::experiments
