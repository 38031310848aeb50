#include "render/texture.hpp"

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "render/picture_check.hpp"
#include "scenes/file_error.hpp"

namespace atropos::render {
namespace {

constexpr int kMaxSide_px = 8192;
constexpr std::uintmax_t kMaxBytes = 512u << 20;

std::string read_bytes(const std::string& file) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error))
        throw scenes::FileError(file, "no such file, expected an image");
    if (std::filesystem::file_size(file, error) > kMaxBytes)
        throw scenes::FileError(file, "larger than 512 MiB, expected an image");
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

cv::Mat decoded(const std::string& file) {
    const std::string bytes = read_bytes(file);
    const PictureHeader header = check_picture(file, bytes);
    if (header.width_px > kMaxSide_px || header.height_px > kMaxSide_px)
        throw scenes::FileError(file, std::to_string(header.width_px) + "x" +
                                          std::to_string(header.height_px) + " pixels, expected at most " +
                                          std::to_string(kMaxSide_px) + " a side");
    try {
        const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
        cv::Mat image = cv::imdecode(encoded, cv::IMREAD_COLOR);
        if (!image.empty()) return image;
    } catch (const cv::Exception&) {  // its message spans lines
    }
    throw scenes::FileError(file, "not a readable image, expected PNG or JPEG");
}

}  // namespace

Texture load_texture(const std::string& file, bool is_colour) {
    const cv::Mat image = decoded(file);
    Texture texture{image.cols, image.rows, is_colour, {}};
    texture.rgba.reserve(4 * image.total());
    for (int y = image.rows - 1; y >= 0; --y) {  // texture coordinates count rows from below
        for (int x = 0; x < image.cols; ++x) {
            const auto& bgr = image.at<cv::Vec3b>(y, x);
            texture.rgba.insert(texture.rgba.end(), {bgr[2], bgr[1], bgr[0], 255});
        }
    }
    return texture;
}

}  // namespace atropos::render
