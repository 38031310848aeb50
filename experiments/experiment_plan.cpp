#include "experiments/experiment_plan.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "experiments/experiment_factors.hpp"
#include "experiments/metrics.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"
#include "scenes/text_file.hpp"
#include "scenes/yaml_document.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using scenes::FileError;
using scenes::YamlDocument;
namespace {

constexpr std::size_t kMaxBytes = 1 << 20;

class Reader {
  public:
    Reader(const fs::path& file, const std::vector<std::string>& overrides)
        : document_(YamlDocument::load(file, kMaxBytes)) {
        factors_.file = file;
        factors_.overrides = overrides;
    }

    ExperimentPlan read() {
        const YAML::Node& root = document_.root;
        if (!root.IsMap()) fail(root, "expected `key: value` lines");
        refuse_unknown(root, {"name", "title", "scene", "job", "set", "grid", "list", "trackers", "seeds",
                              "timeout_s", "table", "published"});
        plan_.name = root["name"] ? word(root["name"]) : factors_.file.stem().string();
        plan_.title = root["title"] ? word(root["title"]) : plan_.name;
        if (!root["scene"]) fail(root, "no key 'scene', expected the base scene's file");
        factors_.scene_file = scenes::resolve_path(factors_.file.parent_path(), word(root["scene"]));
        if (!fs::exists(factors_.scene_file))
            fail(root["scene"], "scene: no file " + scenes::shown(word(root["scene"])));
        const std::string job = root["job"] ? word(root["job"]) : "track";
        if (job != "track" && job != "run")
            fail(root["job"], "job is " + scenes::shown(job) + ", expected track or run");
        factors_.kind = job == "run" ? JobSpec::Kind::kRun : JobSpec::Kind::kTrack;
        if (root["set"]) factors_.base = settings(root["set"]);
        if (root["timeout_s"]) plan_.timeout_s = number(root["timeout_s"], 1.0, 1e7);
        read_list(root["list"]);
        read_grid(root["grid"]);
        read_trackers(root["trackers"]);
        read_seeds(root["seeds"]);
        expand(factors_, plan_);
        read_table(root["table"]);
        read_published(root["published"]);
        return std::move(plan_);
    }

  private:
    [[noreturn]] void fail(const YAML::Node& at, const std::string& what) const { document_.fail(at, what); }

    std::string word(const YAML::Node& node) const {
        if (!node.IsScalar()) fail(node, "expected a word here");
        return node.Scalar();
    }

    double number(const YAML::Node& node, double low, double high) const {
        const auto value = node.IsScalar() ? scenes::parse_number(node.Scalar()) : std::nullopt;
        if (!value || *value < low || *value > high)
            fail(node, fmt::format("expected a number from {} to {}", low, high));
        return *value;
    }

    void refuse_unknown(const YAML::Node& map, const std::set<std::string>& known) const {
        for (const auto& entry : map) {
            const std::string key = entry.first.Scalar();
            if (known.contains(key)) continue;
            const std::string nearest = scenes::nearest_word(key, known);
            fail(entry.first,
                 "unknown key " + scenes::shown(key) +
                     (nearest.empty() ? fmt::format(", expected one of {}", fmt::join(known, " "))
                                      : ", nearest known is '" + nearest + "'"));
        }
    }

    /// A flow text that parses to the same value.
    static std::string flow(const YAML::Node& node) {
        YAML::Emitter out;
        out << YAML::Flow << node;
        return out.c_str();
    }

    void add_setting(Settings& s, const std::string& key, const YAML::Node& value) const {
        if (key == "accel")
            s.accel = static_cast<int>(number(value, 1, 1000));
        else if (key == "command")
            s.command = word(value);
        else if (key.starts_with("degrade.")) {
            Degradation known;
            const std::string field = key.substr(8);
            if (!degradation_field(known, field)) fail(value, "degrade: unknown key " + scenes::shown(field));
            s.degradation.emplace_back(field, number(value, 0.0, 1000.0));
        } else if (key == "protocol") {
            s.protocol = word(value);
            if (s.protocol != "P" && s.protocol != "S") fail(value, "protocol: expected P or S");
        } else if (value.IsMap())
            for (const auto& entry : value) add_setting(s, key + "." + entry.first.Scalar(), entry.second);
        else
            s.overrides.push_back(key + "=" + flow(value));
    }

    Settings settings(const YAML::Node& map) const {
        if (!map.IsMap()) fail(map, "expected settings, `key.path: value` each");
        Settings s;
        for (const auto& entry : map) add_setting(s, entry.first.Scalar(), entry.second);
        check(map, s);
        return s;
    }

    /// The settings on the base scene alone, so that a wrong one is found with its line.
    void check(const YAML::Node& at, const Settings& s) const {
        std::vector<std::string> all = factors_.base.overrides;
        all.insert(all.end(), s.overrides.begin(), s.overrides.end());
        try {
            scenes::load_scene(factors_.scene_file, all);
        } catch (const FileError& error) {
            fail(at, error.what());
        }
    }

    /// `key: [values]`, or `name: {level: settings}`.
    Factor factor(const std::string& name, const YAML::Node& node) const {
        Factor f{name, {}};
        if (node.IsSequence())
            for (const auto& value : node) {
                Settings s;
                add_setting(s, name, value);
                check(value, s);
                f.levels.push_back({value.IsScalar() ? value.Scalar() : flow(value), s});
            }
        else if (node.IsMap())
            for (const auto& entry : node) {
                const bool nothing = entry.second.IsNull();
                f.levels.push_back({entry.first.Scalar(), nothing ? Settings{} : settings(entry.second)});
            }
        if (f.levels.empty()) fail(node, name + ": expected a list of values, or levels with settings");
        return f;
    }

    void read_grid(const YAML::Node& node) {
        if (!node) return;
        if (!node.IsMap())
            fail(node, "grid: expected factors, `key.path: [values]` or `name: {level: settings}`");
        for (const auto& entry : node) factors_.grid.push_back(factor(entry.first.Scalar(), entry.second));
    }

    /// `- {name: N, set: {...}}` is one alternative; `- {name: N, vary: {key: [values]}}` one for each value.
    void read_list(const YAML::Node& node) {
        if (!node) return;
        if (!node.IsSequence()) fail(node, "list: expected alternatives, `- {name: N, set: {...}}`");
        for (const auto& entry : node) {
            if (!entry.IsMap() || !entry["name"]) fail(entry, "list: expected `- {name: N, set: {...}}`");
            refuse_unknown(entry, {"name", "set", "vary"});
            const std::string name = word(entry["name"]);
            const Settings common = entry["set"] ? settings(entry["set"]) : Settings{};
            if (!entry["vary"]) {
                factors_.list.push_back({{{"case", name}, {"value", ""}}, common});
                continue;
            }
            if (!entry["vary"].IsMap() || entry["vary"].size() != 1)
                fail(entry["vary"], "vary: expected one `key: [values]`");
            const Factor f = factor(entry["vary"].begin()->first.Scalar(), entry["vary"].begin()->second);
            for (const Level& level : f.levels) {
                factors_.list.push_back({{{"case", name}, {"value", level.name}}, common});
                append(factors_.list.back().settings, level.settings);
            }
        }
    }

    /// `[e1, e2]`, or `{name: settings}`; `command` names an external one.
    void read_trackers(const YAML::Node& node) {
        Factor f{"tracker", {}};
        if (node && node.IsSequence())
            for (const auto& method : node) {
                Settings s;
                s.overrides = {"tracker.method=" + word(method)};
                check(method, s);
                f.levels.push_back({word(method), s});
            }
        else if (node)
            f = factor("tracker", node);
        if (!f.levels.empty()) factors_.grid.push_back(f);
    }

    void read_seeds(const YAML::Node& node) {
        const auto whole = [&](const YAML::Node& n, double low) {
            const double value = number(n, low, 9e15);
            if (value != std::floor(value)) fail(n, "expected a whole number");
            return static_cast<std::uint64_t>(value);
        };
        if (!node) {
            factors_.seeds = {scenes::load_scene(factors_.scene_file, factors_.base.overrides).seed};
        } else if (node.IsSequence()) {
            for (const auto& seed : node) factors_.seeds.push_back(whole(seed, 0.0));
        } else {
            const std::uint64_t count = whole(node, 1.0);
            if (count > kMaxCells) fail(node, "expected at most a million seeds");
            for (std::uint64_t i = 1; i <= count; ++i) factors_.seeds.push_back(i);
        }
        if (factors_.seeds.empty()) fail(node, "expected a number of seeds, or a list of them");
        plan_.seeds = static_cast<int>(factors_.seeds.size());
    }

    void read_table(const YAML::Node& node) {
        TableSpec& table = plan_.table;
        if (!plan_.factors.empty()) table.rows = plan_.factors.front().first;
        if (plan_.factors.size() > 1) table.columns = plan_.factors.back().first;
        if (factors_.kind == JobSpec::Kind::kTrack)
            table.metrics = {"accuracy_3d_mm", "accuracy_2d_px", "disparity_equivalent_px"};
        if (!node) return;
        if (!node.IsMap()) fail(node, "table: expected rows, columns, metrics");
        refuse_unknown(node, {"rows", "columns", "metrics"});
        const auto known_factor = [&](const YAML::Node& n) {
            for (const auto& f : plan_.factors)
                if (f.first == word(n)) return word(n);
            fail(n, "no factor " + scenes::shown(word(n)) + " in this experiment");
        };
        if (node["rows"]) table.rows = known_factor(node["rows"]);
        if (node["columns"]) table.columns = known_factor(node["columns"]);
        if (!node["metrics"]) return;
        if (!node["metrics"].IsSequence()) fail(node["metrics"], "metrics: expected a list of names");
        table.metrics.clear();
        for (const auto& metric : node["metrics"]) table.metrics.push_back(known_metric(metric));
    }

    std::string known_metric(const YAML::Node& node) const {
        std::vector<std::string> names;
        for (const auto& [name, field] : metric_fields()) names.push_back(name);
        for (const std::string& name : deformation_names()) names.push_back(name);
        if (std::find(names.begin(), names.end(), word(node)) == names.end()) {
            const std::string nearest = scenes::nearest_word(word(node), names);
            fail(node, "no metric " + scenes::shown(word(node)) +
                           (nearest.empty() ? "" : ", nearest known is '" + nearest + "'"));
        }
        return word(node);
    }

    /// `- {tracker: e1, accel: 1, metric: accuracy_3d_mm, mean: 0.47, std: 0.21}`
    void read_published(const YAML::Node& node) {
        if (!node) return;
        if (!node.IsSequence()) fail(node, "published: expected a list of figures");
        for (const auto& entry : node) {
            if (!entry.IsMap() || !entry["metric"] || !entry["mean"])
                fail(entry, "published: expected {FACTOR: level, metric: NAME, mean: X, std: Y}");
            PublishedFigure figure;
            for (const auto& item : entry) {
                const std::string key = item.first.Scalar();
                if (key == "metric")
                    figure.metric = known_metric(item.second);
                else if (key == "mean")
                    figure.mean = number(item.second, -1e9, 1e9);
                else if (key == "std")
                    figure.std = number(item.second, 0.0, 1e9);
                else
                    figure.levels[key] = word(item.second);
            }
            plan_.published.push_back(figure);
        }
    }

    YamlDocument document_;
    ExperimentFactors factors_;
    ExperimentPlan plan_;
};

}  // namespace

ExperimentPlan load_experiment(const fs::path& file, const std::vector<std::string>& overrides) {
    return Reader(file, overrides).read();
}

std::string ExperimentPlan::manifest() const {
    nlohmann::ordered_json json;
    json["name"] = name;
    json["title"] = title;
    for (const auto& [factor, levels] : factors) json["factors"][factor] = levels;
    json["seeds"] = seeds;
    json["timeout_s"] = timeout_s;
    json["jobs"] = nlohmann::ordered_json::array();
    for (const JobSpec& job : jobs)
        json["jobs"].push_back({{"id", job.id}, {"sequence", job.sequence_id}, {"accel", job.accel}});
    json["cells"] = nlohmann::ordered_json::array();
    for (const Cell& cell : cells)
        json["cells"].push_back({{"levels", cell.levels}, {"seed", cell.seed}, {"job", jobs[cell.job].id}});
    json["table"] = {{"rows", table.rows}, {"columns", table.columns}, {"metrics", table.metrics}};
    json["published"] = nlohmann::ordered_json::array();
    for (const PublishedFigure& f : published)
        json["published"].push_back(
            {{"levels", f.levels}, {"metric", f.metric}, {"mean", f.mean}, {"std", f.std}});
    return json.dump(1) + "\n";
}

}  // namespace atropos::experiments
