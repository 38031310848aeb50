#include "experiments/table_layout.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace atropos::experiments {
namespace {

std::string level_of(const CellStatistics& cell, const std::string& factor) {
    const auto at = cell.levels.find(factor);
    return at == cell.levels.end() ? "" : at->second;
}

void add_once(std::vector<std::string>& list, const std::string& item) {
    if (std::find(list.begin(), list.end(), item) == list.end()) list.push_back(item);
}

}  // namespace

std::vector<Table> layout(const nlohmann::ordered_json& manifest, const std::vector<CellStatistics>& cells) {
    const std::string rows = manifest["table"]["rows"], columns = manifest["table"]["columns"];
    std::vector<std::string> metrics = manifest["table"]["metrics"].get<std::vector<std::string>>();
    const bool judged =
        std::any_of(cells.begin(), cells.end(), [](const auto& c) { return !c.verdicts.empty(); });
    if (judged) metrics.insert(metrics.begin(), {"verdict", "cut_error_mm"});
    std::vector<Table> tables;
    for (const std::string& metric : metrics)
        for (const CellStatistics& cell : cells) {
            std::string where;
            for (const auto& [factor, level] : cell.levels)
                if (factor != rows && factor != columns && !level.empty())
                    where += fmt::format("{}{} {}", where.empty() ? "" : ", ", factor, level);
            auto table = std::find_if(tables.begin(), tables.end(),
                                      [&](const Table& t) { return t.metric == metric && t.where == where; });
            if (table == tables.end()) table = tables.insert(table, {metric, where, {}, {}, {}});
            const std::string row = level_of(cell, rows), column = level_of(cell, columns);
            add_once(table->rows, row);
            add_once(table->columns, column);
            table->places[{row, column}] = &cell;
        }
    return tables;
}

}  // namespace atropos::experiments
