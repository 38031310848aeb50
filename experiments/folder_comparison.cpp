#include "experiments/folder_comparison.hpp"

#include <fmt/format.h>
#include <fnmatch.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "experiments/csv_file.hpp"
#include "scenes/file_error.hpp"
#include "scenes/text_file.hpp"
#include "scenes/yaml_document.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using nlohmann::ordered_json;
using scenes::FileError;
namespace {

bool fits(const std::string& pattern, const std::string& text) {
    return fnmatch(pattern.c_str(), text.c_str(), 0) == 0;
}

std::string read_bytes(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    if (!stream) throw FileError(file.string(), "can't be read");
    return bytes;
}

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        lines.push_back(text.substr(at, end - at));
        at = end + 1;
    }
    return lines;
}

class Comparison {
  public:
    Comparison(const Tolerances& tolerances, std::size_t limit) : tolerances_(tolerances), limit_(limit) {}

    void compare(const std::string& name, const fs::path& a, const fs::path& b) {
        name_ = name;
        const std::string before = read_bytes(a), after = read_bytes(b);
        if (before == after) return;
        const std::string extension = a.extension().string();
        if (extension == ".csv")
            compare_csv(lines_of(before), lines_of(after));
        else if (extension == ".json")
            compare_json_text(before, after);
        else
            compare_bytes(before, after);
    }

    void differ(const std::string& what) {
        if (differences_.size() < limit_) differences_.push_back(what);
        ++count_;
    }

    std::vector<std::string> result() const {
        std::vector<std::string> all = differences_;
        if (count_ > all.size()) all.push_back(fmt::format("and {} more", count_ - all.size()));
        return all;
    }

  private:
    /// Empty when `a` and `b` are the same text, or numbers within the tolerance of `key`.
    std::string difference(const std::string& key, const std::string& a, const std::string& b) const {
        if (a == b) return "";
        const auto x = scenes::parse_number(a), y = scenes::parse_number(b);
        if (!x || !y) return fmt::format("{} is '{}', baseline '{}'", key, b, a);
        double allowed = 0.0;
        for (const ToleranceRule& rule : tolerances_.rules)
            if (fits(rule.file, name_) && fits(rule.key, key))
                allowed = rule.absolute + rule.relative * std::abs(*x);
        if (std::abs(*x - *y) <= allowed) return "";
        return fmt::format("{} is {}, baseline {}, tolerance {:.4g}", key, b, a, allowed);
    }

    void compare_csv(const std::vector<std::string>& a, const std::vector<std::string>& b) {
        if (a.empty() || b.empty() || a.front() != b.front()) return differ(name_ + ":1: other columns");
        const std::vector<std::string> columns = split_fields(a.front());
        for (std::size_t i = 1; i < std::min(a.size(), b.size()); ++i) {
            if (a[i] == b[i]) continue;
            const auto x = split_fields(a[i]), y = split_fields(b[i]);
            if (x.size() != columns.size() || y.size() != columns.size()) {
                differ(fmt::format("{}:{}: other number of fields", name_, i + 1));
                continue;
            }
            for (std::size_t k = 0; k < columns.size(); ++k)
                if (const std::string d = difference(columns[k], x[k], y[k]); !d.empty())
                    differ(fmt::format("{}:{}: {}", name_, i + 1, d));
        }
        if (a.size() != b.size()) differ(fmt::format("{}: {} lines, baseline {}", name_, b.size(), a.size()));
    }

    void compare_json_text(const std::string& a, const std::string& b) {
        const ordered_json x = ordered_json::parse(a, nullptr, false),
                           y = ordered_json::parse(b, nullptr, false);
        if (x.is_discarded() || y.is_discarded()) return compare_bytes(a, b);
        compare_json("", x, y);
    }

    void compare_json(const std::string& path, const ordered_json& a, const ordered_json& b) {
        const auto child = [&path](const std::string& key) { return path.empty() ? key : path + "." + key; };
        if (a.is_object() && b.is_object()) {
            for (const auto& [key, value] : a.items())
                if (b.contains(key))
                    compare_json(child(key), value, b[key]);
                else
                    differ(fmt::format("{}: no {}", name_, child(key)));
            for (const auto& [key, value] : b.items())
                if (!a.contains(key)) differ(fmt::format("{}: {} is new", name_, child(key)));
        } else if (a.is_array() && b.is_array() && a.size() == b.size()) {
            for (std::size_t i = 0; i < a.size(); ++i) compare_json(child(std::to_string(i)), a[i], b[i]);
        } else if (a != b) {
            const auto text = [](const ordered_json& v) {
                return v.is_string() ? v.get<std::string>() : v.dump();
            };
            if (const std::string d = difference(path, text(a), text(b)); !d.empty())
                differ(name_ + ": " + d);
        }
    }

    void compare_bytes(const std::string& a, const std::string& b) {
        const auto [x, y] = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
        const auto at = x - a.begin();
        const bool text = a.find('\0') == std::string::npos && b.find('\0') == std::string::npos;
        differ(text ? fmt::format("{}:{}: other text", name_, 1 + std::count(a.begin(), x, '\n'))
                    : fmt::format("{}: differs from byte {} on ({} bytes, baseline {})", name_, at, b.size(),
                                  a.size()));
    }

    const Tolerances& tolerances_;
    std::size_t limit_;
    std::string name_;
    std::size_t count_ = 0;
    std::vector<std::string> differences_;
};

std::set<std::string> files_below(const fs::path& folder, const Tolerances& tolerances) {
    if (!fs::is_directory(folder))
        throw FileError(folder.string(), "no such folder, expected results to compare");
    std::set<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        if (!entry.is_regular_file()) continue;
        const std::string name = fs::relative(entry.path(), folder).generic_string();
        if (std::none_of(tolerances.ignored.begin(), tolerances.ignored.end(),
                         [&](const std::string& pattern) { return fits(pattern, name); }))
            names.insert(name);
    }
    return names;
}

}  // namespace

Tolerances read_tolerances(const fs::path& file) {
    const scenes::YamlDocument document = scenes::YamlDocument::load(file, 1 << 20);
    const YAML::Node& root = document.root;
    if (!root.IsMap()) document.fail(root, "expected `ignore` and `rules`");
    Tolerances tolerances;
    for (const auto& entry : root) {
        const std::string key = entry.first.Scalar();
        if (key != "ignore" && key != "rules")
            document.fail(entry.first, "unknown key " + scenes::shown(key) + ", expected ignore or rules");
        if (!entry.second.IsSequence()) document.fail(entry.second, key + ": expected a list");
        for (const auto& item : entry.second) {
            if (key == "ignore") {
                if (!item.IsScalar()) document.fail(item, "ignore: expected file patterns");
                tolerances.ignored.push_back(item.Scalar());
                continue;
            }
            if (!item.IsMap()) document.fail(item, "rules: expected {file, key, absolute, relative}");
            ToleranceRule rule;
            for (const auto& field : item) {
                const std::string name = field.first.Scalar();
                if (!field.second.IsScalar()) document.fail(field.second, name + ": expected one value");
                const auto number = scenes::parse_number(field.second.Scalar());
                if (name == "file")
                    rule.file = field.second.Scalar();
                else if (name == "key")
                    rule.key = field.second.Scalar();
                else if ((name == "absolute" || name == "relative") && number && *number >= 0.0)
                    (name == "absolute" ? rule.absolute : rule.relative) = *number;
                else
                    document.fail(field.first, "expected file, key, or absolute and relative of at least 0");
            }
            tolerances.rules.push_back(rule);
        }
    }
    return tolerances;
}

std::vector<std::string> compare_folders(const fs::path& baseline, const fs::path& result,
                                         const Tolerances& tolerances, std::size_t limit) {
    const std::set<std::string> before = files_below(baseline, tolerances),
                                after = files_below(result, tolerances);
    Comparison comparison(tolerances, limit);
    for (const std::string& name : before)
        if (after.contains(name))
            comparison.compare(name, baseline / name, result / name);
        else
            comparison.differ(name + ": is missing, the baseline has it");
    for (const std::string& name : after)
        if (!before.contains(name)) comparison.differ(name + ": is new, the baseline lacks it");
    return comparison.result();
}

}  // namespace atropos::experiments
