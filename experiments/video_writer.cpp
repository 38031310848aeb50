#include "experiments/video_writer.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <string>

#include "scenes/file_error.hpp"

namespace atropos::experiments {
using scenes::FileError;

VideoWriter::VideoWriter(std::filesystem::path file, cv::Size size, double fps_hz)
    : file_(std::move(file)), size_(size) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw FileError(file_.string(), "no pipe to ffmpeg");
    const std::string pixels = std::to_string(size.width) + "x" + std::to_string(size.height),
                      rate = std::to_string(fps_hz);
    const std::string name = file_.string();
    const char* arguments[] = {"ffmpeg",
                               "-loglevel",
                               "error",
                               "-y",
                               "-f",
                               "rawvideo",
                               "-pix_fmt",
                               "bgr24",
                               "-s",
                               pixels.c_str(),
                               "-r",
                               rate.c_str(),
                               "-i",
                               "-",
                               "-an",
                               "-c:v",
                               "libx264",
                               "-threads",
                               "1",
                               "-preset",
                               "veryfast",
                               "-crf",
                               "20",
                               "-pix_fmt",
                               "yuv420p",
                               "-vf",
                               "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                               "-fflags",
                               "+bitexact",
                               "-flags:v",
                               "+bitexact",
                               "-movflags",
                               "+faststart",
                               name.c_str(),
                               nullptr};
    child_ = fork();
    if (child_ == 0) {
        dup2(ends[0], STDIN_FILENO);
        execvp("ffmpeg", const_cast<char**>(arguments));
        _exit(127);
    }
    ::close(ends[0]);
    pipe_ = ends[1];
    if (child_ < 0) throw FileError(file_.string(), "ffmpeg can't be started");
    std::signal(SIGPIPE, SIG_IGN);  // a dead ffmpeg shows as a failed write
}

VideoWriter::~VideoWriter() {
    if (pipe_ >= 0) ::close(pipe_);
    if (child_ > 0) waitpid(child_, nullptr, 0);
}

void VideoWriter::add(const cv::Mat& bgr) {
    const cv::Mat whole = bgr.isContinuous() ? bgr : bgr.clone();
    CV_Assert(whole.type() == CV_8UC3 && whole.size() == size_);
    const auto* bytes = whole.data;
    std::size_t left = whole.total() * 3;
    while (left > 0) {
        const ssize_t written = ::write(pipe_, bytes, left);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0)
            throw FileError(file_.string(), "ffmpeg ended early (is there space left, and libx264?)");
        bytes += written;
        left -= static_cast<std::size_t>(written);
    }
}

void VideoWriter::close() {
    ::close(pipe_);
    pipe_ = -1;
    int status = 0;
    waitpid(child_, &status, 0);
    child_ = -1;
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        throw FileError(file_.string(), WIFEXITED(status) && WEXITSTATUS(status) == 127
                                            ? "no ffmpeg program, expected Debian's package ffmpeg"
                                            : "ffmpeg failed");
}

}  // namespace atropos::experiments
