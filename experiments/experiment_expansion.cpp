#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "experiments/experiment_factors.hpp"
#include "experiments/sha256.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
using scenes::FileError;
namespace {

class Expansion {
  public:
    Expansion(const ExperimentFactors& factors, ExperimentPlan& plan) : factors_(factors), plan_(plan) {}

    void run() {
        const std::vector<Alternative> list =
            factors_.list.empty() ? std::vector<Alternative>(1) : factors_.list;
        std::size_t count = list.size() * factors_.seeds.size();
        for (const Factor& f : factors_.grid) count *= f.levels.size();
        if (count > kMaxCells)
            throw FileError(factors_.file.string(),
                            fmt::format("{} jobs, expected at most a million", count));
        for (const Alternative& alternative : list)
            for (const std::uint64_t seed : factors_.seeds)
                expand_grid(alternative, seed, 0, factors_.base, {});
        group_by_sequence();
    }

  private:
    void note_level(const std::string& factor, const std::string& level) {
        auto at = std::find_if(plan_.factors.begin(), plan_.factors.end(),
                               [&](const auto& f) { return f.first == factor; });
        if (at == plan_.factors.end()) at = plan_.factors.insert(at, {factor, {}});
        if (std::find(at->second.begin(), at->second.end(), level) == at->second.end())
            at->second.push_back(level);
    }

    void expand_grid(const Alternative& alternative, std::uint64_t seed, std::size_t depth,
                     const Settings& chosen, const std::map<std::string, std::string>& levels) {
        if (depth < factors_.grid.size()) {
            for (const Level& level : factors_.grid[depth].levels) {
                Settings next = chosen;
                append(next, level.settings);
                std::map<std::string, std::string> next_levels = levels;
                next_levels[factors_.grid[depth].name] = level.name;
                note_level(factors_.grid[depth].name, level.name);
                expand_grid(alternative, seed, depth + 1, next, next_levels);
            }
            return;
        }
        Settings all = chosen;
        append(all, alternative.settings);
        all.overrides.push_back(fmt::format("seed={}", seed));
        all.overrides.insert(all.overrides.end(), factors_.overrides.begin(), factors_.overrides.end());
        Cell cell{levels, seed, add_job(all)};
        for (const auto& [factor, level] : alternative.levels) {
            cell.levels[factor] = level;
            note_level(factor, level);
        }
        plan_.cells.push_back(cell);
    }

    std::size_t add_job(const Settings& s) {
        JobSpec job;
        job.kind = factors_.kind;
        job.scene = scenes::load_scene(factors_.scene_file, s.overrides);
        job.accel = std::max(1, s.accel);
        job.reprojected = s.protocol == "P";
        for (const auto& [field, value] : s.degradation) *degradation_field(job.degradation, field) = value;
        job.command = s.command;
        const std::string resolved = scenes::to_yaml(job.scene);
        const std::string protocol = job.reprojected ? "protocol: P\n" : "";
        const Degradation& d = job.degradation;
        const std::string degraded =
            d.any() ? fmt::format("degrade: {} {} {} {} {} {}\n", d.noise_levels, d.blur_px, d.contrast_loss,
                                  d.tip_error_mm, d.calibration_error_deg, d.occlusion_px)
                    : "";
        job.id = sha256(fmt::format("{}job: {}\naccel: {}\ncommand: {}\n{}", resolved,
                                    factors_.kind == JobSpec::Kind::kRun ? "run" : "track", job.accel,
                                    job.command, protocol + degraded))
                     .substr(0, 16);
        scenes::SceneConfig sequence =
            job.scene;  // what no picture and no measured end depends on, put aside
        sequence.tracking = {};
        sequence.tracking.tips = job.scene.tracking.tips;
        sequence.cut = {};
        job.sequence_id = sha256(scenes::to_yaml(sequence) + protocol).substr(0, 16);
        const auto [at, is_new] = known_.emplace(job.id, plan_.jobs.size());
        if (is_new) plan_.jobs.push_back(std::move(job));
        return at->second;
    }

    /// Stable: sequences in the order in which they are first needed.
    void group_by_sequence() {
        std::map<std::string, std::size_t> first;
        std::vector<std::size_t> order(plan_.jobs.size());
        for (std::size_t i = 0; i < order.size(); ++i) {
            order[i] = i;
            first.emplace(plan_.jobs[i].sequence_id, i);
        }
        std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
            return first.at(plan_.jobs[a].sequence_id) < first.at(plan_.jobs[b].sequence_id);
        });
        std::vector<JobSpec> jobs;
        std::vector<std::size_t> place(order.size());
        for (const std::size_t i : order) {
            place[i] = jobs.size();
            jobs.push_back(std::move(plan_.jobs[i]));
        }
        plan_.jobs = std::move(jobs);
        for (Cell& cell : plan_.cells) cell.job = place[cell.job];
    }

    const ExperimentFactors& factors_;
    ExperimentPlan& plan_;
    std::map<std::string, std::size_t> known_;  ///< place of a job by its id
};

}  // namespace

void append(Settings& to, const Settings& more) {
    to.overrides.insert(to.overrides.end(), more.overrides.begin(), more.overrides.end());
    if (more.accel > 0) to.accel = more.accel;
    if (!more.command.empty()) to.command = more.command;
    if (!more.protocol.empty()) to.protocol = more.protocol;
    to.degradation.insert(to.degradation.end(), more.degradation.begin(), more.degradation.end());
}

void expand(const ExperimentFactors& factors, ExperimentPlan& plan) {
    Expansion(factors, plan).run();
}

}  // namespace atropos::experiments
