#include "experiments/output_folder.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "scenes/file_error.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using scenes::FileError;

void check_output(const fs::path& target, bool force) {
    std::error_code error;
    if (target.empty()) throw FileError("-o", "no folder named");
    if (!fs::exists(target, error)) return;
    if (!fs::is_directory(target)) throw FileError(target.string(), "is a file, expected a folder");
    if (!fs::is_empty(target) && !force)
        throw FileError(target.string(), "folder is not empty, expected a new one or --force");
}

OutputFolder::OutputFolder(fs::path target, bool force, Leftover leftover)
    : target_(std::move(target)), leftover_(leftover) {
    while (target_.filename().empty() && target_.has_parent_path() && target_ != target_.root_path())
        target_ = target_.parent_path();  // a trailing slash
    check_output(target_, force);
    partial_ = target_;
    partial_ += ".partial";
    std::error_code error;
    if (leftover_ != Leftover::kContinue) fs::remove_all(partial_, error);
    fs::create_directories(partial_, error);
    if (error) throw FileError(partial_.string(), "can't be made: " + error.message());
}

OutputFolder::~OutputFolder() {
    std::error_code error;
    if (!committed_ && (leftover_ == Leftover::kRemove || fs::is_empty(partial_, error)))
        fs::remove_all(partial_, error);
}

void OutputFolder::commit() {
    std::error_code error;
    fs::remove_all(target_, error);
    fs::rename(partial_, target_, error);
    if (error) throw FileError(target_.string(), "can't be put in place: " + error.message());
    committed_ = true;
}

void write_file(const fs::path& file, const std::string& bytes) {
    const auto fail = [&] {
        const std::string why = std::strerror(errno);
        std::error_code error;
        fs::remove(file, error);
        throw FileError(file.string(), "can't be written: " + why);
    };
    std::FILE* stream = std::fopen(file.c_str(), "wb");
    if (!stream) fail();
    const bool written =
        std::fwrite(bytes.data(), 1, bytes.size(), stream) == bytes.size() && std::fflush(stream) == 0;
    if (std::fclose(stream) != 0 || !written) fail();
}

}  // namespace atropos::experiments
