#pragma once

#include <cstdio>
#include <filesystem>
#include <string_view>

namespace atropos::experiments {

/// A file written piece by piece; every failure (full disk included) throws scenes::FileError.
class AppendFile {
  public:
    AppendFile() = default;
    AppendFile(std::filesystem::path file, std::string_view first_line);
    ~AppendFile();
    AppendFile(AppendFile&&) noexcept;
    AppendFile& operator=(AppendFile&&) noexcept;

    void write(std::string_view bytes);
    void close();

  private:
    std::filesystem::path file_;
    std::FILE* stream_ = nullptr;
};

}  // namespace atropos::experiments
