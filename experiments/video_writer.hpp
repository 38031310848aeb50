#pragma once

#include <sys/types.h>

#include <filesystem>
#include <opencv2/core.hpp>

namespace atropos::experiments {

/// Pipes BGR pictures of one size to the ffmpeg program (H.264, one thread, bit exact).
class VideoWriter {
  public:
    /// Throws scenes::FileError when ffmpeg can't be started.
    VideoWriter(std::filesystem::path file, cv::Size size, double fps_hz);
    ~VideoWriter();
    VideoWriter(const VideoWriter&) = delete;
    VideoWriter& operator=(const VideoWriter&) = delete;

    void add(const cv::Mat& bgr);

    /// Ends the video; throws scenes::FileError when ffmpeg failed.
    void close();

  private:
    std::filesystem::path file_;
    cv::Size size_;
    pid_t child_ = -1;
    int pipe_ = -1;
};

}  // namespace atropos::experiments
