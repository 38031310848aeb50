#include "experiments/picture_file.hpp"

#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "experiments/output_folder.hpp"
#include "render/picture_check.hpp"
#include "scenes/file_error.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using scenes::FileError;
namespace {

constexpr std::size_t kMaxBytes = 512u << 20;

std::string read_bytes(const fs::path& file) {
    if (!fs::is_regular_file(file)) throw FileError(file.string(), "no such picture");
    if (fs::file_size(file) > kMaxBytes)
        throw FileError(file.string(), "larger than 512 MiB, expected a picture");
    std::ifstream stream(file, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    if (!stream) throw FileError(file.string(), "can't be read");
    return bytes;
}

}  // namespace

cv::Mat read_picture(const fs::path& file, int width_px, int height_px) {
    const std::string name = file.string(), bytes = read_bytes(file);
    const render::PictureHeader header = render::check_picture(name, bytes);
    if (header.bits != 8) throw FileError(name, std::to_string(header.bits) + " bits a channel, expected 8");
    if (header.width_px != width_px || header.height_px != height_px)
        throw FileError(name, std::to_string(header.width_px) + "x" + std::to_string(header.height_px) +
                                  " px, expected the calibration's " + std::to_string(width_px) + "x" +
                                  std::to_string(height_px));
    cv::Mat picture;
    try {
        const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
        picture = cv::imdecode(encoded, cv::IMREAD_ANYCOLOR);
    } catch (const cv::Exception&) {
    }
    if (picture.empty() || picture.depth() != CV_8U)
        throw FileError(name, "can't be decoded, expected an 8-bit PNG or JPEG");
    return picture;
}

cv::Size picture_size(const fs::path& file) {
    const render::PictureHeader header = render::check_picture(file.string(), read_bytes(file));
    if (header.width_px > 65535 || header.height_px > 65535)
        throw FileError(file.string(), "larger than 65535 px");
    return {static_cast<int>(header.width_px), static_cast<int>(header.height_px)};
}

std::string encode_png(const cv::Mat& picture) {
    std::vector<unsigned char> bytes;
    cv::imencode(
        ".png", picture, bytes,
        {cv::IMWRITE_PNG_COMPRESSION, 1, cv::IMWRITE_PNG_STRATEGY, cv::IMWRITE_PNG_STRATEGY_DEFAULT});
    return {bytes.begin(), bytes.end()};
}

void write_jpeg(const fs::path& file, const cv::Mat& picture) {
    std::vector<unsigned char> bytes;
    cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, 85});
    write_file(file, {bytes.begin(), bytes.end()});
}

void write_png(const fs::path& file, const cv::Mat& picture) {
    write_file(file, encode_png(picture));
}

}  // namespace atropos::experiments
