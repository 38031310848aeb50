#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "experiments/result_statistics.hpp"

namespace atropos::experiments {

/// One table: a metric under one combination of the factors that are neither rows nor columns.
struct Table {
    std::string metric, where;
    std::vector<std::string> rows, columns;
    std::map<std::pair<std::string, std::string>, const CellStatistics*> places;  ///< of the cells laid out
};

/// The manifest's tables, in its order; closed loops get their verdicts and cuts before them. `cells` must
/// outlive the tables.
std::vector<Table> layout(const nlohmann::ordered_json& manifest, const std::vector<CellStatistics>& cells);

}  // namespace atropos::experiments
