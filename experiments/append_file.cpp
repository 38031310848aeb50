#include "experiments/append_file.hpp"

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include "scenes/file_error.hpp"

namespace atropos::experiments {

AppendFile::AppendFile(std::filesystem::path file, std::string_view first_line)
    : file_(std::move(file)), stream_(std::fopen(file_.c_str(), "wb")) {
    if (!stream_)
        throw scenes::FileError(file_.string(), std::string("can't be written: ") + std::strerror(errno));
    write(first_line);
}

AppendFile::~AppendFile() {
    if (stream_) std::fclose(stream_);
}

AppendFile::AppendFile(AppendFile&& other) noexcept
    : file_(std::move(other.file_)), stream_(std::exchange(other.stream_, nullptr)) {}

AppendFile& AppendFile::operator=(AppendFile&& other) noexcept {
    std::swap(file_, other.file_);
    std::swap(stream_, other.stream_);
    return *this;
}

void AppendFile::write(std::string_view bytes) {
    if (std::fwrite(bytes.data(), 1, bytes.size(), stream_) != bytes.size())
        throw scenes::FileError(file_.string(), std::string("can't be written: ") + std::strerror(errno));
}

void AppendFile::close() {
    if (!stream_) return;
    const bool failed = std::fclose(std::exchange(stream_, nullptr)) != 0;
    if (failed)
        throw scenes::FileError(file_.string(), std::string("can't be written: ") + std::strerror(errno));
}

}  // namespace atropos::experiments
