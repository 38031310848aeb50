#include "scenes/yaml_document.hpp"

#include <yaml-cpp/yaml.h>

#include <set>

#include "scenes/file_error.hpp"
#include "scenes/text_file.hpp"

namespace atropos::scenes {
namespace {

constexpr int kMaxDepth = 32;
constexpr int kMaxNodes = 200000;

/// Brackets nest by recursion inside the parser: refuse deep ones before it sees them.
int flow_depth(const std::string& text) {
    int depth = 0, deepest = 0;
    for (const char c : text) {
        if (c == '[' || c == '{') deepest = std::max(deepest, ++depth);
        if (c == ']' || c == '}') depth = std::max(0, depth - 1);
    }
    return deepest;
}

/// Walks the whole tree once, aliases expanded, so that no later reader can loop or explode.
void check(const YamlDocument& document, const YAML::Node& node, int depth, int& nodes) {
    if (depth > kMaxDepth) document.fail(node, "nested deeper than " + std::to_string(kMaxDepth) + " levels");
    if (++nodes > kMaxNodes) document.fail(node, "more than " + std::to_string(kMaxNodes) + " values");
    if (node.IsSequence())
        for (const auto& child : node) check(document, child, depth + 1, nodes);
    if (node.IsMap()) {
        std::set<std::string> keys;
        for (const auto& entry : node) {
            const YAML::Node& key = entry.first;
            if (!key.IsScalar()) document.fail(key, "a key that is not a word");
            if (!keys.insert(key.Scalar()).second)
                document.fail(key, "key " + shown(key.Scalar()) + " stands twice");
            check(document, entry.second, depth + 1, nodes);
        }
    }
}

}  // namespace

void YamlDocument::fail(const YAML::Node& at, const std::string& what) const {
    const int line = at.Mark().line;
    if (line < 0) throw FileError(name, what);
    throw FileError(name, line + 1, what);
}

YamlDocument YamlDocument::load(const std::filesystem::path& file, std::size_t max_bytes) {
    return parse(file.string(), read_text_file(file, max_bytes));
}

YamlDocument YamlDocument::parse(const std::string& name, std::string text) {
    // OpenCV writes a directive that is not YAML's; blanked, the line numbers stay.
    if (text.starts_with("%YAML:1.0")) text.replace(0, 9, "#        ");
    if (flow_depth(text) > kMaxDepth)
        throw FileError(name, "brackets nested deeper than " + std::to_string(kMaxDepth) + " levels");
    YamlDocument document{name, {}};
    try {
        const std::vector<YAML::Node> all = YAML::LoadAll(text);
        if (all.size() != 1)
            throw FileError(name, std::to_string(all.size()) + " YAML documents, expected one");
        document.root = all.front();
        int nodes = 0;
        check(document, document.root, 0, nodes);
    } catch (const YAML::Exception& error) {
        const std::string what = "not valid YAML: " + error.msg;
        if (error.mark.line < 0) throw FileError(name, what);
        throw FileError(name, error.mark.line + 1, what);
    }
    return document;
}

}  // namespace atropos::scenes
