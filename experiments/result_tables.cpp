#include "experiments/result_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "experiments/output_folder.hpp"
#include "experiments/result_plots.hpp"
#include "experiments/table_layout.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using nlohmann::ordered_json;
namespace {

const std::vector<std::string> kVerdicts = {"cut", "missed", "aborted"};

using Levels = std::map<std::string, std::string>;

/// The published figure that speaks of these levels and this metric.
std::optional<std::pair<double, double>> published(const ordered_json& manifest, const Levels& levels,
                                                   const std::string& metric) {
    for (const auto& figure : manifest["published"]) {
        if (figure["metric"] != metric) continue;
        const auto wanted = figure["levels"].get<Levels>();
        const bool fits = std::all_of(wanted.begin(), wanted.end(), [&](const auto& level) {
            const auto at = levels.find(level.first);
            return at != levels.end() && at->second == level.second;
        });
        if (fits) return std::pair(figure["mean"].get<double>(), figure["std"].get<double>());
    }
    return std::nullopt;
}

std::string cells_csv(const ExperimentResults& results, const std::vector<CellStatistics>& cells) {
    std::string text;
    std::vector<std::string> factors;
    if (results.manifest.contains("factors"))
        for (const auto& [name, levels] : results.manifest["factors"].items()) factors.push_back(name);
    for (const std::string& factor : factors) text += csv_field(factor) + ",";
    text +=
        "metric,mean,std,max,published_mean,published_std,frames,lost_frames,seeds,failed_jobs,missing_"
        "jobs\n";
    for (const CellStatistics& cell : cells) {
        std::string head;
        for (const std::string& factor : factors)
            head += csv_field(cell.levels.contains(factor) ? cell.levels.at(factor) : "") + ",";
        const std::string tail = fmt::format(",{},{},{},{},{}\n", cell.frames, cell.lost_frames, cell.seeds,
                                             cell.failed_jobs, cell.missing_jobs);
        for (const auto& [name, v] : cell.metrics) {
            const auto theirs = published(results.manifest, cell.levels, name);
            text += fmt::format("{}{},{:.6f},{:.6f},{:.6f},{}{}", head, name, v.mean, v.std, v.max,
                                theirs ? fmt::format("{},{}", theirs->first, theirs->second) : ",", tail);
        }
        for (const auto& [name, count] :
             std::map<std::string, double>{{"failed_frames", static_cast<double>(cell.failed_frames)},
                                           {"silent_failures", static_cast<double>(cell.silent_failures)}})
            text += fmt::format("{}{},{},,,,{}", head, name, count, tail);
        if (cell.verdicts.empty()) continue;
        for (const std::string& verdict : kVerdicts) {
            const int k = cell.verdicts.contains(verdict) ? cell.verdicts.at(verdict) : 0;
            text += fmt::format("{}{},{},,,,{}", head, verdict, k, tail);
        }
    }
    return text;
}

/// How many were cut, with the share's interval at 95 %.
std::string verdict_text(const CellStatistics& cell) {
    if (cell.seeds == 0) return cell.missing_jobs > 0 ? "(not yet)" : "failed";
    std::vector<std::string> parts;
    for (const std::string& verdict : kVerdicts)
        parts.push_back(
            fmt::format("{} {}", verdict, cell.verdicts.contains(verdict) ? cell.verdicts.at(verdict) : 0));
    const int k = cell.verdicts.contains("cut") ? cell.verdicts.at("cut") : 0;
    const auto [low, high] = wilson_interval(k, cell.seeds + cell.failed_jobs);
    std::string text = fmt::format("{}{} of {} ({:.3f} to {:.3f})", fmt::join(parts, ", "),
                                   cell.failed_jobs > 0 ? fmt::format(", failed {}", cell.failed_jobs) : "",
                                   cell.seeds + cell.failed_jobs, low, high);
    text += fmt::format("; collisions {}, attempts {:.2f}", cell.collisions,
                        static_cast<double>(cell.attempts) / cell.seeds);
    for (const auto& [reason, count] : cell.reasons) text += fmt::format("; {} aborted: {}", count, reason);
    return text;
}

/// Sizes of the errors along the thread of all threads that were cut, missed ones too.
std::string cut_error_text(const CellStatistics& cell) {
    const std::vector<double>& errors = cell.cut_errors_mm;
    if (errors.empty()) return "";
    double sum = 0.0;
    for (const double error : errors) sum += error;
    const auto place = static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(errors.size()))) - 1;
    return fmt::format("mean {:.2f}, 95 % {:.2f}, largest {:.2f}, n {}",
                       sum / static_cast<double>(errors.size()), errors[place], errors.back(), errors.size());
}

/// What one place of a table says, for Markdown and for LaTeX.
std::string place_text(const ordered_json& manifest, const CellStatistics& cell, const std::string& metric,
                       const char* plus_minus) {
    if (metric == "verdict") return verdict_text(cell);
    if (metric == "cut_error_mm") return cut_error_text(cell);
    const auto at = cell.metrics.find(metric);
    std::string text = at != cell.metrics.end()
                           ? fmt::format("{:.3g} {} {:.3g}", at->second.mean, plus_minus, at->second.std)
                       : cell.missing_jobs > 0 ? "(not yet)"
                       : cell.seeds > 0        ? "lost"
                                               : "failed";
    if (const auto theirs = published(manifest, cell.levels, metric))
        text += theirs->second > 0.0
                    ? fmt::format(" (paper {} {} {})", theirs->first, plus_minus, theirs->second)
                    : fmt::format(" (paper {})", theirs->first);
    if (cell.lost_frames > 0) text += fmt::format(", {} lost", cell.lost_frames);
    if (cell.failed_jobs > 0) text += fmt::format(", {} jobs failed", cell.failed_jobs);
    return text;
}

std::string counts(const ExperimentResults& results, const std::vector<CellStatistics>& cells) {
    long least = -1, most = 0;
    for (const CellStatistics& cell : cells) {
        least = least < 0 ? cell.frames : std::min(least, cell.frames);
        most = std::max(most, cell.frames);
    }
    const int seeds = results.manifest["seeds"].get<int>();
    std::string text =
        fmt::format("Mean and standard deviation over {} frames a cell, {} seed{}",
                    least == most ? std::to_string(most) : fmt::format("{} to {}", least, most), seeds,
                    seeds == 1 ? "" : "s");
    if (const std::size_t missing = results.missing(); missing > 0)
        text +=
            fmt::format("; unfinished: {} of {} jobs are missing", missing, results.manifest["jobs"].size());
    if (const std::size_t failed = results.failed(); failed > 0)
        text += fmt::format("; {} jobs failed", failed);
    return text + ".";
}

std::string tex(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (std::string_view("_%&#").find(c) != std::string_view::npos) out += '\\';
        out += c;
    }
    return out;
}

std::string tex_tables(const ExperimentResults& results, const std::vector<CellStatistics>& cells) {
    std::string text;
    const std::string rows = results.manifest["table"]["rows"];
    for (const Table& table : layout(results.manifest, cells)) {
        text += fmt::format("\\begin{{table}}\n\\caption{{{}: {}{}. {}}}\n\\begin{{tabular}}{{l{}}}\n{}",
                            tex(results.manifest["title"]), tex(table.metric),
                            table.where.empty() ? "" : ", " + tex(table.where), counts(results, cells),
                            std::string(table.columns.size(), 'l'), tex(rows));
        for (const std::string& column : table.columns) text += " & " + tex(column);
        text += " \\\\\n\\hline\n";
        for (const std::string& row : table.rows) {
            text += tex(row);
            for (const std::string& column : table.columns) {
                const auto at = table.places.find({row, column});
                text +=
                    " & " + (at == table.places.end()
                                 ? std::string()
                                 : tex(place_text(results.manifest, *at->second, table.metric, "$\\pm$")));
            }
            text += " \\\\\n";
        }
        text += "\\end{tabular}\n\\end{table}\n\n";
    }
    return text;
}

}  // namespace

std::string markdown_tables(const ExperimentResults& results) {
    const std::vector<CellStatistics> cells = statistics(results);
    const std::string rows = results.manifest["table"]["rows"],
                      columns = results.manifest["table"]["columns"];
    std::string text =
        fmt::format("# {}\n\n{}\n", results.manifest["title"].get<std::string>(), counts(results, cells));
    for (const Table& table : layout(results.manifest, cells)) {
        text +=
            fmt::format("\n## {}{}\n\n| {} |", table.metric, table.where.empty() ? "" : ", " + table.where,
                        columns.empty() ? rows : rows + " \\ " + columns);
        for (const std::string& column : table.columns) text += " " + column + " |";
        text += "\n|---|";
        for (size_t i = 0; i < table.columns.size(); ++i) text += "---|";
        text += "\n";
        for (const std::string& row : table.rows) {
            text += "| " + row + " |";
            for (const std::string& column : table.columns) {
                const auto at = table.places.find({row, column});
                text += " " +
                        (at == table.places.end()
                             ? std::string()
                             : place_text(results.manifest, *at->second, table.metric, "±")) +
                        " |";
            }
            text += "\n";
        }
    }
    return text;
}

void write_tables(const ExperimentResults& results, const fs::path& folder) {
    const std::vector<CellStatistics> cells = statistics(results);
    const std::string name = results.manifest["name"];
    OutputFolder tables(folder / "tables", true);
    write_file(tables.path() / "cells.csv", cells_csv(results, cells));
    write_file(tables.path() / (name + ".md"), markdown_tables(results));
    write_file(tables.path() / (name + ".tex"), tex_tables(results, cells));
    tables.commit();
    write_plots(results.manifest, cells, folder / "plots");
}

}  // namespace atropos::experiments
