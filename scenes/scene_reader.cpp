#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

#include "scenes/field_table.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"
#include "scenes/text_file.hpp"
#include "scenes/yaml_document.hpp"

namespace atropos::scenes {
namespace {

constexpr std::size_t kMaxBytes = 4 << 20;
constexpr std::size_t kMaxIncludes = 16;

std::string describe(const Range& range) {
    const auto text = [](double x) {
        std::string s = std::to_string(x);
        while (s.back() == '0') s.pop_back();
        if (s.back() == '.') s.pop_back();
        return s;
    };
    if (std::isinf(range.low) && std::isinf(range.high)) return "a number";
    if (std::isinf(range.high))
        return (range.without_low ? "a number above " : "a number of at least ") + text(range.low);
    return std::string("a number ") + (range.without_low ? "above " : "from ") + text(range.low) + " to " +
           text(range.high);
}

/// Writes the values that a document holds into a scene and leaves the others as they are.
class Reader final : public FieldVisitor {
  public:
    Reader(const YamlDocument& document, std::filesystem::path base)
        : document_(document), base_(std::move(base)), node_(document.root) {}

    void read(SceneConfig& scene) {
        if (!node_.IsMap()) document_.fail(node_, "expected `key: value` lines");
        seen_.insert("include");
        seen_.insert("randomise");  // read by draw_randomised
        visit_fields(*this, scene);
        refuse_unknown();
    }

    void number(const Field& field, double& value, const Range& range) override {
        if (const YAML::Node node = find(field)) value = number_at(node, field.key, range);
    }

    void integer(const Field& field, int& value, int low, int high) override {
        const YAML::Node node = find(field);
        if (!node) return;
        const auto parsed = node.IsScalar() ? parse_integer(node.Scalar()) : std::nullopt;
        if (!parsed || *parsed < low || *parsed > high)
            wrong(node, field.key,
                  "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
        value = static_cast<int>(*parsed);
    }

    void seed(const Field& field, std::uint64_t& value) override {
        const YAML::Node node = find(field);
        if (!node) return;
        const auto parsed = node.IsScalar() ? parse_integer(node.Scalar()) : std::nullopt;
        if (!parsed || *parsed < 0) wrong(node, field.key, "a whole number of at least 0");
        value = static_cast<std::uint64_t>(*parsed);
    }

    void flag(const Field& field, bool& value) override {
        const YAML::Node node = find(field);
        if (!node) return;
        if (!node.IsScalar() || (node.Scalar() != "true" && node.Scalar() != "false"))
            wrong(node, field.key, "true or false");
        value = node.Scalar() == "true";
    }

    void text(const Field& field, std::string& value, const Words& words) override {
        const YAML::Node node = find(field);
        if (!node) return;
        std::string expected = "a word";
        if (!words.empty()) {
            expected = "one of";
            for (const auto& word : words) expected += " " + std::string(word);
        }
        if (!node.IsScalar()) wrong(node, field.key, expected);
        if (!words.empty() && std::find(words.begin(), words.end(), node.Scalar()) == words.end())
            wrong(node, field.key, expected);
        value = node.Scalar();
    }

    void path(const Field& field, std::string& value) override {
        const YAML::Node node = find(field);
        if (!node) return;
        if (!node.IsScalar()) wrong(node, field.key, "a file name");
        value = node.Scalar();
        if (value.empty()) return;
        const std::filesystem::path found = resolve_path(base_, value);
        if (!file_exists(found)) document_.fail(node, std::string(field.key) + ": no file " + shown(value));
        value = found.string();
    }

    void vector(const Field& field, Eigen::Vector3d& value, const Range& range) override {
        const YAML::Node node = find(field);
        if (!node) return;
        if (!node.IsSequence() || node.size() != 3) wrong(node, field.key, "three numbers [x, y, z]");
        for (int i = 0; i < 3; ++i) value[i] = number_at(node[i], field.key, range);
    }

    void vectors(const Field& field, std::vector<Eigen::Vector3d>& values, const Range& range) override {
        const YAML::Node node = find(field);
        if (!node) return;
        const std::string expected = "a list of [x, y, z], at most 1000";
        if (!node.IsSequence() || node.size() > 1000) wrong(node, field.key, expected);
        values.clear();
        for (const YAML::Node& row : node) {
            if (!row.IsSequence() || row.size() != 3) wrong(row, field.key, expected);
            Eigen::Vector3d value;
            for (int i = 0; i < 3; ++i) value[i] = number_at(row[i], field.key, range);
            values.push_back(value);
        }
    }

    void section(const Field& field, const std::function<void()>& fields) override {
        const YAML::Node node = find(field);
        if (!node) return;
        if (!node.IsMap()) wrong(node, field.key, "a section of `key: value` lines");
        const YAML::Node outer = node_;
        std::set<std::string> outer_seen;
        outer_seen.swap(seen_);
        node_.reset(node);
        fields();
        refuse_unknown();
        node_.reset(outer);
        seen_.swap(outer_seen);
    }

  private:
    YAML::Node find(const Field& field) {
        seen_.insert(std::string(field.key));
        const YAML::Node& node = node_;
        return node[std::string(field.key)];
    }

    double number_at(const YAML::Node& node, std::string_view key, const Range& range) const {
        const auto value = node.IsScalar() ? parse_number(node.Scalar()) : std::nullopt;
        if (!value || *value < range.low || *value > range.high || (range.without_low && *value == range.low))
            wrong(node, key, describe(range));
        return in_si(*value, unit_of_key(key));
    }

    [[noreturn]] void wrong(const YAML::Node& node, std::string_view key, const std::string& expected) const {
        const std::string got = node.IsScalar()     ? shown(node.Scalar())
                                : node.IsMap()      ? "a section"
                                : node.IsSequence() ? "a list"
                                                    : "nothing";
        document_.fail(node, std::string(key) + " is " + got + ", expected " + expected);
    }

    void refuse_unknown() const {
        for (const auto& entry : node_) {
            const std::string& key = entry.first.Scalar();
            if (seen_.contains(key)) continue;
            const std::string nearest = nearest_word(key, seen_);
            std::string known;
            for (const std::string& k : seen_) known += " " + k;
            document_.fail(entry.first, "unknown key " + shown(key) +
                                            (nearest.empty() ? ", expected one of" + known
                                                             : ", nearest known is '" + nearest + "'"));
        }
    }

    const YamlDocument& document_;
    std::filesystem::path base_;
    YAML::Node node_;
    std::set<std::string> seen_;
};

void read_file(SceneConfig& scene, const std::filesystem::path& file,
               std::vector<std::filesystem::path>& open);

void read_document(SceneConfig& scene, const YamlDocument& document, const std::filesystem::path& base,
                   std::vector<std::filesystem::path>& open) {
    if (document.root.IsMap()) {
        const YAML::Node& root = document.root;
        if (const YAML::Node include = root["include"]) {
            if (!include.IsScalar()) document.fail(include, "include is no file name, expected one");
            const std::filesystem::path file = resolve_path(base, include.Scalar());
            if (!file_exists(file)) document.fail(include, "include: no file " + shown(include.Scalar()));
            std::error_code error;
            const auto canonical = std::filesystem::weakly_canonical(file, error);
            if (std::find(open.begin(), open.end(), canonical) != open.end())
                document.fail(include, "include: " + shown(include.Scalar()) + " includes itself");
            if (open.size() >= kMaxIncludes) document.fail(include, "include: more than 16 files deep");
            read_file(scene, file, open);
        }
    }
    Reader(document, base).read(scene);
}

void read_file(SceneConfig& scene, const std::filesystem::path& file,
               std::vector<std::filesystem::path>& open) {
    std::error_code error;
    open.push_back(std::filesystem::weakly_canonical(file, error));
    read_document(scene, YamlDocument::load(file, kMaxBytes), file.parent_path(), open);
    open.pop_back();
}

/// "camera.fps_hz=25" as the document "camera: {fps_hz: 25}".
YamlDocument override_document(const std::string& text) {
    const std::string name = "--set " + text;
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
        throw FileError(name, "no assignment, expected key.path=value");
    YAML::Node node = YamlDocument::parse(name, text.substr(equals + 1) + "\n").root;
    std::string path = text.substr(0, equals);
    while (true) {
        const std::size_t dot = path.rfind('.');
        const std::string key = dot == std::string::npos ? path : path.substr(dot + 1);
        if (key.empty()) throw FileError(name, "an empty key, expected key.path=value");
        YAML::Node parent(YAML::NodeType::Map);
        parent[key] = node;
        node = parent;
        if (dot == std::string::npos) break;
        path.resize(dot);
    }
    return {name, node};
}

void apply_overrides(SceneConfig& scene, const std::vector<std::string>& overrides) {
    std::vector<std::filesystem::path> open;
    for (const std::string& text : overrides) {
        const YamlDocument document = override_document(text);
        Reader(document, std::filesystem::current_path()).read(scene);
    }
}

}  // namespace

std::filesystem::path resolve_path(const std::filesystem::path& base, const std::string& name) {
    const std::filesystem::path path(name);
    if (path.is_absolute()) return path;
    if (file_exists(base / path)) return base / path;
    const char* share = std::getenv("ATROPOS_SHARE");
    for (const char* folder : {share ? share : "", ATROPOS_INSTALLED_SHARE, ATROPOS_SOURCE_SHARE})
        if (*folder && file_exists(folder / path)) return folder / path;
    return base / path;
}

SceneConfig load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
    SceneConfig scene;
    std::vector<std::filesystem::path> open;
    read_file(scene, file, open);
    if (scene.name.empty()) scene.name = file.stem().string();
    apply_overrides(scene, overrides);
    return scene;
}

SceneConfig parse_scene(const std::string& name, const std::string& text, const std::filesystem::path& base,
                        const std::vector<std::string>& overrides) {
    SceneConfig scene;
    std::vector<std::filesystem::path> open;
    read_document(scene, YamlDocument::parse(name, text), base, open);
    apply_overrides(scene, overrides);
    return scene;
}

}  // namespace atropos::scenes
