#include "experiments/result_statistics.hpp"

#include <algorithm>
#include <cmath>

#include "experiments/json_file.hpp"
#include "scenes/file_error.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using nlohmann::ordered_json;
using scenes::FileError;
namespace {

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

/// What only closed loops have.
void gather_run(CellStatistics& cell, const ordered_json& result) {
    const std::string verdict = result["verdict"];
    ++cell.verdicts[verdict];
    if (verdict == "aborted") ++cell.reasons[result.at("reason").get<std::string>()];
    if (result.contains("cut"))
        cell.cut_errors_mm.push_back(std::abs(result["cut"].at("error_mm").get<double>()));
    cell.collisions += result.at("collisions").get<int>();
    cell.attempts += result.at("attempts").get<int>();
}

void gather(Gathering& g, const ordered_json& result) {
    if (result.at("status") == "failed") {
        ++g.cell.failed_jobs;
        return;
    }
    ++g.cell.seeds;
    if (result.contains("verdict")) gather_run(g.cell, result);
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
    results.manifest = read_json_object(manifest);
    guarded(manifest, [&] {
        check_manifest(results.manifest);
        return 0;
    });
    for (const auto& job : results.manifest["jobs"]) {
        const std::string id = job["id"].get<std::string>();
        const fs::path file = folder / "jobs" / id / "result.json";
        if (!fs::exists(file)) continue;
        const ordered_json result = read_json_object(file);
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
        if (is_new) gathered.emplace_back().cell.levels = levels;
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
        std::sort(g.cell.cut_errors_mm.begin(), g.cell.cut_errors_mm.end());
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

}  // namespace atropos::experiments
