#include "scenes/yaml_document.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <set>
#include <sstream>

#include "scenes/file_error.hpp"
#include "scenes/text_file.hpp"

namespace atropos::scenes {
namespace {

constexpr int kMaxDepth = 32;
constexpr int kMaxNodes = 200000;

/// Hears the parser's events and stops it before it descends too deep; the tree is built only of what passed.
class DepthGuard : public YAML::EventHandler {
  public:
    explicit DepthGuard(const std::string& name) : name_(name) {}

    void OnSequenceStart(const YAML::Mark& at, const std::string&, YAML::anchor_t,
                         YAML::EmitterStyle::value) override {
        descend(at);
    }
    void OnMapStart(const YAML::Mark& at, const std::string&, YAML::anchor_t,
                    YAML::EmitterStyle::value) override {
        descend(at);
    }
    void OnSequenceEnd() override { --depth_; }
    void OnMapEnd() override { --depth_; }
    void OnDocumentStart(const YAML::Mark&) override {}
    void OnDocumentEnd() override {}
    void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
    void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
    void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}

  private:
    void descend(const YAML::Mark& at) {
        if (++depth_ > kMaxDepth)
            throw FileError(name_, at.line + 1,
                            "nested deeper than " + std::to_string(kMaxDepth) + " levels");
    }

    const std::string& name_;
    int depth_ = 0;
};

/// Refuses deep nesting and a second document. YAML::LoadAll would do for the latter, but a stray comma
/// outside brackets is never consumed, and it then makes empty documents until the memory ends.
void check_events(const std::string& name, const std::string& text) {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    DepthGuard guard(name);
    if (!parser.HandleNextDocument(guard)) throw FileError(name, "no YAML document");
    if (parser.HandleNextDocument(guard)) throw FileError(name, "more than one YAML document, expected one");
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
    YamlDocument document{name, {}};
    try {
        check_events(name, text);
        document.root = YAML::Load(text);
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
