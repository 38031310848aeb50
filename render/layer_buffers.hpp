#pragma once

#include <cstdint>

#include "render/gl.hpp"

namespace atropos::render {

/// Framebuffer with linear colour (RGBA16F), depth in metres (R32F), label (R8UI) and a depth buffer (32F).
class LayerBuffers {
  public:
    LayerBuffers(const GlFunctions& gl, int width_px, int height_px);
    ~LayerBuffers();
    LayerBuffers(const LayerBuffers&) = delete;
    LayerBuffers& operator=(const LayerBuffers&) = delete;

    void bind() const;
    void clear() const;
    void copy_from(const LayerBuffers& other) const;

    /// Rows from the top; `half_rgba` 4 halves, `depth_m` a float, `label` a byte a pixel.
    void read(std::uint16_t* half_rgba, float* depth_m, std::uint8_t* label) const;

  private:
    const GlFunctions& gl_;
    int width_px_, height_px_;
    GLuint framebuffer_ = 0;
    GLuint textures_[4] = {};
};

}  // namespace atropos::render
