#include "render/picture_check.hpp"

#include <array>
#include <cstdint>

#include "scenes/file_error.hpp"

namespace atropos::render {
using scenes::FileError;
namespace {

constexpr std::string_view kPngSignature("\x89PNG\r\n\x1a\n", 8);
constexpr std::string_view kJpegSignature("\xff\xd8\xff", 3);

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

/// Walks all chunks, so that the decoder only ever sees files whose checksums hold.
PictureHeader check_png(const std::string& name, std::string_view bytes) {
    PictureHeader header;
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

PictureHeader check_jpeg(const std::string& name, std::string_view bytes) {
    PictureHeader header;
    std::size_t at = 2;
    while (at + 9 < bytes.size()) {
        const auto byte = [&](std::size_t i) {
            return static_cast<long>(static_cast<unsigned char>(bytes[at + i]));
        };
        const long marker = byte(1);
        if (byte(0) != 0xff) break;
        if (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc)
            header = {byte(7) << 8 | byte(8), byte(5) << 8 | byte(6), static_cast<int>(byte(4))};
        at += 2 + static_cast<std::size_t>(byte(2) << 8 | byte(3));
        if (marker != 0xda) continue;
        // The scan: within it 0xff is never followed by the end's marker.
        if (header.width_px <= 0 || header.height_px <= 0) break;
        if (at >= bytes.size() || bytes.find("\xff\xd9", at) == std::string_view::npos)
            throw FileError(name, "truncated JPEG");
        return header;
    }
    throw FileError(name, "corrupt JPEG");
}

}  // namespace

PictureHeader check_picture(const std::string& name, std::string_view bytes) {
    if (bytes.starts_with(kPngSignature)) return check_png(name, bytes);
    if (bytes.starts_with(kJpegSignature)) return check_jpeg(name, bytes);
    throw FileError(name, "no picture, expected PNG or JPEG");
}

}  // namespace atropos::render
