#include "render/texture.hpp"

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

namespace atropos::render {
namespace {

constexpr int kMaxSide_px = 8192;

cv::Mat decoded(const std::string& file) {
    if (!std::filesystem::is_regular_file(file))
        throw std::runtime_error(file + ": no such file, expected an image");
    try {
        cv::Mat image = cv::imread(file, cv::IMREAD_COLOR);
        if (!image.empty()) return image;
    } catch (const cv::Exception&) {  // its message spans lines
    }
    throw std::runtime_error(file + ": not a readable image, expected PNG or JPEG");
}

}  // namespace

Texture load_texture(const std::string& file, bool is_colour) {
    const cv::Mat image = decoded(file);
    if (image.cols > kMaxSide_px || image.rows > kMaxSide_px) {
        throw std::runtime_error(file + ": " + std::to_string(image.cols) + "x" + std::to_string(image.rows) +
                                 " pixels, expected at most " + std::to_string(kMaxSide_px) + " a side");
    }
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
