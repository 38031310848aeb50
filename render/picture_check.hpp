#pragma once

#include <string>
#include <string_view>

namespace atropos::render {

struct PictureHeader {
    long width_px = 0, height_px = 0;
    int bits = 0;  ///< a channel
};

/// Walks the chunks of a PNG or the segments of a JPEG up to its end, so that a decoder only ever sees whole
/// files: the usual ones print their own complaints. Throws scenes::FileError that begins with `name`.
PictureHeader check_picture(const std::string& name, std::string_view bytes);

}  // namespace atropos::render
