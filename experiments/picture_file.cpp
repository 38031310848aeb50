#include "experiments/picture_file.hpp"

#include <array>
#include <cstdint>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string_view>

#include "experiments/output_folder.hpp"
#include "scenes/file_error.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using scenes::FileError;
namespace {

constexpr std::string_view kPngSignature("\x89PNG\r\n\x1a\n", 8);
constexpr std::string_view kJpegSignature("\xff\xd8\xff", 3);
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

std::uint32_t big_endian(std::string_view bytes) {
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i)
        value = value << 8 | static_cast<unsigned char>(bytes[static_cast<size_t>(i)]);
    return value;
}

std::uint32_t crc32(std::string_view bytes) {
    static const auto table = [] {
        std::array<std::uint32_t, 256> t{};
        for (std::uint32_t n = 0; n < 256; ++n) {
            std::uint32_t c = n;
            for (int k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320u ^ (c >> 1) : c >> 1;
            t[n] = c;
        }
        return t;
    }();
    std::uint32_t c = 0xffffffffu;
    for (const char b : bytes) c = table[(c ^ static_cast<unsigned char>(b)) & 0xff] ^ (c >> 8);
    return ~c;
}

struct Header {
    long width_px, height_px;
    int bits;
};

/// Walks all chunks, so that the decoder only ever sees files whose checksums hold.
Header check_png(const std::string& name, std::string_view bytes) {
    Header header{0, 0, 0};
    std::size_t at = kPngSignature.size();
    while (true) {
        if (at + 12 > bytes.size()) throw FileError(name, "truncated PNG");
        const std::size_t length = big_endian(bytes.substr(at));
        if (length > bytes.size() - at - 12) throw FileError(name, "truncated PNG");
        const std::string_view type = bytes.substr(at + 4, 4), data = bytes.substr(at + 8, length);
        if (crc32(bytes.substr(at + 4, length + 4)) != big_endian(bytes.substr(at + 8 + length)))
            throw FileError(name, "corrupt PNG (checksum)");
        if (type == "IHDR" && length == 13)
            header = {static_cast<long>(big_endian(data)), static_cast<long>(big_endian(data.substr(4))),
                      data[8]};
        if (type == "IEND") break;
        at += length + 12;
    }
    if (header.width_px <= 0) throw FileError(name, "PNG without a header");
    return header;
}

Header check_jpeg(const std::string& name, std::string_view bytes) {
    std::size_t at = 2;
    while (at + 9 < bytes.size()) {
        const auto marker = static_cast<unsigned char>(bytes[at + 1]);
        const auto byte = [&](std::size_t i) {
            return static_cast<long>(static_cast<unsigned char>(bytes[at + i]));
        };
        if (static_cast<unsigned char>(bytes[at]) != 0xff) break;
        if (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc)
            return {byte(7) << 8 | byte(8), byte(5) << 8 | byte(6), static_cast<int>(byte(4))};
        at += 2 + static_cast<std::size_t>(byte(2) << 8 | byte(3));
    }
    throw FileError(name, "corrupt JPEG");
}

Header check_picture(const std::string& name, std::string_view bytes) {
    if (bytes.starts_with(kPngSignature)) return check_png(name, bytes);
    if (bytes.starts_with(kJpegSignature)) return check_jpeg(name, bytes);
    throw FileError(name, "no picture, expected PNG or JPEG");
}

}  // namespace

cv::Mat read_picture(const fs::path& file, int width_px, int height_px) {
    const std::string name = file.string(), bytes = read_bytes(file);
    const Header header = check_picture(name, bytes);
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
    const Header header = check_picture(file.string(), read_bytes(file));
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
