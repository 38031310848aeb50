#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace atropos::render {

/// An image to lay on a mesh: rows from texture coordinate v = 0, 8-bit R G B A. Repeats beyond [0, 1].
struct Texture {
    int width_px = 0;
    int height_px = 0;
    bool is_colour = true;  ///< sRGB-coded colour; false: a normal map, alpha multiplying the roughness
    std::vector<std::uint8_t> rgba;
};

/// Reads a PNG or JPEG. Throws std::runtime_error with the file's name for what OpenCV cannot read or what is
/// larger than 8192 pixels a side.
Texture load_texture(const std::string& file, bool is_colour);

}  // namespace atropos::render
