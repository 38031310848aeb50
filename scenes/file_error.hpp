#pragma once

#include <stdexcept>
#include <string>

namespace atropos::scenes {

/// A file that can't be used: "FILE[:LINE]: what is wrong, what was expected", one line.
class FileError : public std::runtime_error {
  public:
    FileError(const std::string& file, const std::string& what) : std::runtime_error(file + ": " + what) {}
    FileError(const std::string& file, int line, const std::string& what)
        : std::runtime_error(file + ":" + std::to_string(line) + ": " + what) {}
};

}  // namespace atropos::scenes
