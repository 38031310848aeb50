#pragma once

#include <yaml-cpp/node/node.h>

#include <filesystem>
#include <string>

namespace atropos::scenes {

/// A YAML text as a tree, with errors that name file and line. The only place that parses YAML.
struct YamlDocument {
    std::string name;  ///< of the file, for error lines
    YAML::Node root;

    /// Throws FileError on unreadable files, bad YAML, more than one document, nesting deeper than 32, or an
    /// anchor that contains itself.
    static YamlDocument load(const std::filesystem::path& file, std::size_t max_bytes);
    static YamlDocument parse(const std::string& name, std::string text);

    [[noreturn]] void fail(const YAML::Node& at, const std::string& what) const;
};

}  // namespace atropos::scenes
