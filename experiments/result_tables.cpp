#include "experiments/result_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>

#include "experiments/output_folder.hpp"
#include "scenes/file_error.hpp"
#include "scenes/text_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using nlohmann::ordered_json;
using scenes::FileError;
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 30;
const std::vector<std::string> kVerdicts = {"cut", "missed", "aborted"};

ordered_json read_json(const fs::path& file) {
    const ordered_json json = ordered_json::parse(scenes::read_text_file(file, kMaxBytes), nullptr, false);
    if (!json.is_object())
        throw FileError(file.string(), "no JSON object, expected the file as it was written");
    return json;
}

/// Runs `read`, which takes a JSON file apart, and says which file it was when that fails.
template <class Read>
auto guarded(const fs::path& file, const Read& read) {
    try {
        return read();
    } catch (const nlohmann::json::exception&) {
        throw FileError(file.string(),
                        "a key is missing or of another type, expected the file as it was written");
    }
}

void check_manifest(const ordered_json& m) {
    for (const auto& job : m.at("jobs")) job.at("id").get<std::string>();
    for (const auto& cell : m.at("cells")) {
        cell.at("levels").get<std::map<std::string, std::string>>();
        cell.at("job").get<std::string>();
    }
    m.at("table").at("rows").get<std::string>();
    m.at("table").at("columns").get<std::string>();
    m.at("table").at("metrics").get<std::vector<std::string>>();
    for (const auto& figure : m.at("published")) figure.at("mean").get<double>();
}

/// Pools means and standard deviations over frames: exact, from each job's moments.
class Pool {
  public:
    void add(double mean, double std, double max, long n) {
        const auto count = static_cast<double>(n);
        n_ += count;
        sum_ += count * mean;
        square_ += count * (std * std + mean * mean);
        max_ = std::max(max_, max);
    }
    CellStatistics::Value value() const {
        const double mean = sum_ / n_;
        return {mean, std::sqrt(std::max(0.0, square_ / n_ - mean * mean)), max_};
    }
    bool empty() const { return n_ == 0.0; }

  private:
    double n_ = 0.0, sum_ = 0.0, square_ = 0.0, max_ = 0.0;
};

struct Gathering {
    CellStatistics cell;
    std::map<std::string, Pool> pools;
};

void gather(Gathering& g, const ordered_json& result) {
    if (result.at("status") == "failed") {
        ++g.cell.failed_jobs;
        return;
    }
    ++g.cell.seeds;
    if (result.contains("verdict")) ++g.cell.verdicts[result["verdict"].get<std::string>()];
    const ordered_json& metrics = result.at("metrics");
    const long frames = metrics.at("frames").get<long>(), lost = metrics.at("lost_frames").get<long>();
    g.cell.frames += frames;
    g.cell.lost_frames += lost;
    g.cell.silent_failures += metrics.at("silent_failures").get<long>();
    g.cell.failed_frames +=
        std::lround(metrics.at("failure_rate").get<double>() * static_cast<double>(frames));
    for (const auto& [name, value] : metrics.items())
        if (value.is_object() && name != "reacquire_frames")
            g.pools[name].add(value.at("mean").get<double>(), value.at("std").get<double>(),
                              value.at("max").get<double>(), frames - lost);
}

}  // namespace

std::size_t ExperimentResults::missing() const {
    std::size_t count = 0;
    for (const auto& job : manifest["jobs"])
        if (!by_job.contains(job["id"].get<std::string>())) ++count;
    return count;
}

std::size_t ExperimentResults::failed() const {
    return static_cast<std::size_t>(std::count_if(
        by_job.begin(), by_job.end(), [](const auto& r) { return r.second["status"] == "failed"; }));
}

ExperimentResults read_results(const fs::path& folder) {
    ExperimentResults results;
    const fs::path manifest = folder / "experiment.json";
    results.manifest = read_json(manifest);
    guarded(manifest, [&] {
        check_manifest(results.manifest);
        return 0;
    });
    for (const auto& job : results.manifest["jobs"]) {
        const std::string id = job["id"].get<std::string>();
        const fs::path file = folder / "jobs" / id / "result.json";
        if (!fs::exists(file)) continue;
        const ordered_json result = read_json(file);
        guarded(file, [&] {
            Gathering check;
            gather(check, result);
            return 0;
        });
        results.by_job[id] = result;
    }
    return results;
}

std::vector<CellStatistics> statistics(const ExperimentResults& results) {
    std::vector<Gathering> gathered;
    std::map<std::map<std::string, std::string>, std::size_t> place;
    for (const auto& entry : results.manifest["cells"]) {
        const auto levels = entry["levels"].get<std::map<std::string, std::string>>();
        const auto [at, is_new] = place.emplace(levels, gathered.size());
        if (is_new) gathered.push_back({{levels, {}, {}}, {}});
        Gathering& g = gathered[at->second];
        const auto result = results.by_job.find(entry["job"].get<std::string>());
        if (result == results.by_job.end())
            ++g.cell.missing_jobs;
        else
            gather(g, result->second);
    }
    std::vector<CellStatistics> cells;
    for (Gathering& g : gathered) {
        for (const auto& [name, pool] : g.pools)
            if (!pool.empty()) g.cell.metrics[name] = pool.value();
        cells.push_back(std::move(g.cell));
    }
    return cells;
}

std::pair<double, double> wilson_interval(int k, int n) {
    if (n == 0) return {0.0, 1.0};
    constexpr double z = 1.959963984540054;
    const double count = n, p = k / count, zz = z * z / count;
    const double centre = (p + 0.5 * zz) / (1.0 + zz),
                 half = z / (1.0 + zz) * std::sqrt(p * (1.0 - p) / count + 0.25 * zz / count);
    return {std::max(0.0, centre - half), std::min(1.0, centre + half)};
}

namespace {

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

std::string field(std::string text) {
    std::replace(text.begin(), text.end(), ',', ';');
    return text;
}

std::string cells_csv(const ExperimentResults& results, const std::vector<CellStatistics>& cells) {
    std::string text;
    std::vector<std::string> factors;
    if (results.manifest.contains("factors"))
        for (const auto& [name, levels] : results.manifest["factors"].items()) factors.push_back(name);
    for (const std::string& factor : factors) text += field(factor) + ",";
    text +=
        "metric,mean,std,max,published_mean,published_std,frames,lost_frames,seeds,failed_jobs,missing_"
        "jobs\n";
    for (const CellStatistics& cell : cells) {
        std::string head;
        for (const std::string& factor : factors)
            head += field(cell.levels.contains(factor) ? cell.levels.at(factor) : "") + ",";
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

/// What one place of a table says, for Markdown and for LaTeX.
std::string place_text(const ordered_json& manifest, const CellStatistics& cell, const std::string& metric,
                       const char* plus_minus) {
    if (metric == "verdict") {
        if (cell.seeds == 0) return cell.missing_jobs > 0 ? "(not yet)" : "failed";
        std::vector<std::string> parts;
        for (const std::string& verdict : kVerdicts)
            parts.push_back(fmt::format("{} {}", verdict,
                                        cell.verdicts.contains(verdict) ? cell.verdicts.at(verdict) : 0));
        const int k = cell.verdicts.contains("cut") ? cell.verdicts.at("cut") : 0;
        const auto [low, high] = wilson_interval(k, cell.seeds + cell.failed_jobs);
        return fmt::format("{}{} of {} ({:.2f} to {:.2f})", fmt::join(parts, ", "),
                           cell.failed_jobs > 0 ? fmt::format(", failed {}", cell.failed_jobs) : "",
                           cell.seeds + cell.failed_jobs, low, high);
    }
    const auto at = cell.metrics.find(metric);
    std::string text = at != cell.metrics.end()
                           ? fmt::format("{:.3g} {} {:.3g}", at->second.mean, plus_minus, at->second.std)
                       : cell.missing_jobs > 0 ? "(not yet)"
                       : cell.seeds > 0        ? "lost"
                                               : "failed";
    if (const auto theirs = published(manifest, cell.levels, metric))
        text += fmt::format(" (paper {} {} {})", theirs->first, plus_minus, theirs->second);
    if (cell.lost_frames > 0) text += fmt::format(", {} lost", cell.lost_frames);
    if (cell.failed_jobs > 0) text += fmt::format(", {} jobs failed", cell.failed_jobs);
    return text;
}

/// One table: a metric under one combination of the factors that are neither rows nor columns.
struct Table {
    std::string metric, where;
    std::vector<std::string> rows, columns;
    std::map<std::pair<std::string, std::string>, const CellStatistics*> places;
};

std::string level_of(const CellStatistics& cell, const std::string& factor) {
    const auto at = cell.levels.find(factor);
    return at == cell.levels.end() ? "" : at->second;
}

void add_once(std::vector<std::string>& list, const std::string& item) {
    if (std::find(list.begin(), list.end(), item) == list.end()) list.push_back(item);
}

std::vector<Table> layout(const ordered_json& manifest, const std::vector<CellStatistics>& cells) {
    const std::string rows = manifest["table"]["rows"], columns = manifest["table"]["columns"];
    std::vector<std::string> metrics = manifest["table"]["metrics"].get<std::vector<std::string>>();
    const bool judged =
        std::any_of(cells.begin(), cells.end(), [](const auto& c) { return !c.verdicts.empty(); });
    if (judged) metrics.insert(metrics.begin(), "verdict");
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

std::string counts(const ExperimentResults& results, const std::vector<CellStatistics>& cells) {
    long least = -1, most = 0;
    for (const CellStatistics& cell : cells) {
        least = least < 0 ? cell.frames : std::min(least, cell.frames);
        most = std::max(most, cell.frames);
    }
    std::string text =
        fmt::format("Mean and standard deviation over {} frames a cell, {} seeds",
                    least == most ? std::to_string(most) : fmt::format("{} to {}", least, most),
                    results.manifest["seeds"].get<int>());
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

/// A data file, a script that draws it, and the drawing where gnuplot is installed.
void write_plot(const Table& table, const std::string& rows, const std::string& name,
                const fs::path& folder) {
    const bool numeric = std::all_of(table.rows.begin(), table.rows.end(), [](const std::string& r) {
        return scenes::parse_number(r).has_value();
    });
    std::string data = field(rows.empty() ? "row" : rows), script;
    for (const std::string& column : table.columns) data += fmt::format(",{0} mean,{0} std", field(column));
    data += "\n";
    for (const std::string& row : table.rows) {
        data += field(row);
        for (const std::string& column : table.columns) {
            const auto at = table.places.find({row, column});
            const bool known = at != table.places.end() && at->second->metrics.contains(table.metric);
            data += known ? fmt::format(",{:.6f},{:.6f}", at->second->metrics.at(table.metric).mean,
                                        at->second->metrics.at(table.metric).std)
                          : ",,";
        }
        data += "\n";
    }
    script = fmt::format(
        "# gnuplot {0}.gp draws {0}.svg\nset terminal svg size 640,400\nset output '{0}.svg'\nset datafile "
        "separator ','\nset key top left\nset grid\nset xlabel '{1}' noenhanced\nset ylabel '{2}' "
        "noenhanced\nset title '{3}' noenhanced\nset yrange [0:*]\nplot ",
        name, rows, table.metric, table.where);
    for (size_t i = 0; i < table.columns.size(); ++i)
        script += fmt::format("{}'{}.csv' skip 1 using {}:{}:{}{} with yerrorlines title '{}' noenhanced",
                              i == 0 ? "" : ", \\\n     ", name, numeric ? "1" : "0", 2 * i + 2, 2 * i + 3,
                              numeric ? "" : ":xtic(1)", table.columns[i]);
    write_file(folder / (name + ".csv"), data);
    write_file(folder / (name + ".gp"), script + "\n");
    std::string quoted;
    for (const char c : folder.string()) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    const std::string draw = fmt::format("cd '{}' && gnuplot '{}.gp' 2>/dev/null", quoted, name);
    if (std::system(draw.c_str()) != 0) {
        std::error_code error;
        fs::remove(folder / (name + ".svg"), error);
    }
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
    OutputFolder plots(folder / "plots", true);
    std::map<std::string, int> used;
    for (const Table& table : layout(results.manifest, cells)) {
        if (table.metric == "verdict") continue;
        const int number = ++used[table.metric];
        write_plot(table, results.manifest["table"]["rows"],
                   number == 1 ? table.metric : fmt::format("{}_{}", table.metric, number), plots.path());
    }
    plots.commit();
}

}  // namespace atropos::experiments
