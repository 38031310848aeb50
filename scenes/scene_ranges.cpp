#include "scenes/scene_ranges.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>

#include "scenes/random_stream.hpp"
#include "scenes/scene_file.hpp"
#include "scenes/text_file.hpp"
#include "scenes/yaml_document.hpp"

namespace atropos::scenes {
namespace {

constexpr std::size_t kMaxBytes = 4 << 20;
constexpr int kMaxIncludes = 16;

std::pair<double, double> bounds(const YamlDocument& document, const YAML::Node& node) {
    if (!node.IsSequence() || node.size() != 2) document.fail(node, "expected [low, high]");
    double value[2] = {0.0, 0.0};
    for (std::size_t i = 0; i < 2; ++i) {
        const auto parsed = node[i].IsScalar() ? parse_number(node[i].Scalar()) : std::nullopt;
        if (!parsed) document.fail(node, "expected [low, high]");
        value[i] = *parsed;
    }
    if (value[1] < value[0]) document.fail(node, "low lies above high");
    return {value[0], value[1]};
}

/// Six figures: what a person would write, and what the scene file then holds.
std::string six_figures(double value) {
    if (value == 0.0) return "0";
    const double scale = std::pow(10.0, 5 - static_cast<int>(std::floor(std::log10(std::abs(value)))));
    return decimal(std::round(value * scale) / scale);
}

std::string draw(const YamlDocument& document, const YAML::Node& node, RandomStream& stream) {
    if (node.IsSequence()) {
        const auto [low, high] = bounds(document, node);
        return six_figures(stream.uniform(low, high));
    }
    if (!node.IsMap() || node.size() != 1)
        document.fail(node,
                      "expected [low, high], {log: [low, high]}, {whole: [low, high]} or {choice: [...]}");
    const std::string kind = node.begin()->first.Scalar();
    const YAML::Node value = node.begin()->second;
    if (kind == "choice") {
        if (!value.IsSequence() || value.size() == 0) document.fail(node, "choice: expected a list");
        const YAML::Node chosen = value[static_cast<std::size_t>(stream.integer(value.size()))];
        if (!chosen.IsScalar()) document.fail(node, "choice: expected words or numbers");
        return chosen.Scalar();
    }
    const auto [low, high] = bounds(document, value);
    if (kind == "log") {
        if (!(low > 0.0)) document.fail(node, "log: expected bounds above 0");
        return six_figures(std::exp(stream.uniform(std::log(low), std::log(high))));
    }
    if (kind != "whole")
        document.fail(node, "unknown kind " + shown(kind) + ", expected log, whole or choice");
    const double first = std::ceil(low), count = std::floor(high) - first + 1.0;
    if (!(count >= 1.0 && count < 1e15)) document.fail(node, "whole: no whole number in it");
    return decimal(first + static_cast<double>(stream.integer(static_cast<std::uint64_t>(count))));
}

void draw_file(const std::filesystem::path& file, std::uint64_t seed, int depth, DrawnValues& values) {
    const YamlDocument document = YamlDocument::load(file, kMaxBytes);
    const YAML::Node& root = document.root;
    if (!root.IsMap()) return;
    if (const YAML::Node include = root["include"]; include && include.IsScalar() && depth < kMaxIncludes)
        draw_file(resolve_path(file.parent_path(), include.Scalar()), seed, depth + 1, values);
    const YAML::Node ranges = root["randomise"];
    if (!ranges) return;
    if (!ranges.IsMap()) document.fail(ranges, "randomise: expected `key.path: [low, high]` lines");
    for (const auto& entry : ranges) {
        const std::string key = entry.first.Scalar();
        RandomStream stream(seed, "randomise." + key);
        const std::string value = draw(document, entry.second, stream);
        try {
            load_scene(file, {key + "=" + value});
        } catch (const std::exception& error) {
            document.fail(entry.first, error.what());
        }
        const auto at =
            std::find_if(values.begin(), values.end(), [&](const auto& v) { return v.first == key; });
        if (at == values.end())
            values.emplace_back(key, value);
        else
            at->second = value;
    }
}

}  // namespace

DrawnValues draw_randomised(const std::filesystem::path& file, std::uint64_t seed) {
    DrawnValues values;
    draw_file(file, seed, 0, values);
    return values;
}

}  // namespace atropos::scenes
