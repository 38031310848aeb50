#pragma once

#include <filesystem>

#include "experiments/table_layout.hpp"

namespace atropos::experiments {

/// Data and gnuplot script of each table of figures, and the picture where gnuplot is installed.
void write_plots(const nlohmann::ordered_json& manifest, const std::vector<CellStatistics>& cells,
                 const std::filesystem::path& folder);

/// `text` as a field of a CSV file: commas become semicolons.
std::string csv_field(std::string text);

}  // namespace atropos::experiments
