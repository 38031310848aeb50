#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

namespace atropos::experiments {

/// Reads a PNG or JPEG of 8 bits a channel, gray or BGR, of exactly this size. Throws scenes::FileError on
/// anything else: another size or depth, truncated or corrupt files (a PNG's checksums are verified before it
/// is decoded).
cv::Mat read_picture(const std::filesystem::path& file, int width_px, int height_px);

/// Width and height of a PNG or JPEG from its header; throws scenes::FileError.
cv::Size picture_size(const std::filesystem::path& file);

/// PNG bytes of 8-bit gray, 8-bit BGR or 16-bit gray pictures; the same bytes for the same pixels.
std::string encode_png(const cv::Mat& picture);

/// Quality 85.
void write_jpeg(const std::filesystem::path& file, const cv::Mat& picture);

void write_png(const std::filesystem::path& file, const cv::Mat& picture);

}  // namespace atropos::experiments
