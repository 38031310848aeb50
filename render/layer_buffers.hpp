#pragma once

#include <cstdint>
#include <opencv2/core/types.hpp>
#include <span>

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
    void copy_from(const LayerBuffers& other, std::span<const cv::Rect> boxes) const;

    /// Into whole images, rows from the top: a byte a pixel; within `boxes` 4 halves and a float a pixel.
    void read_labels(std::uint8_t* labels) const;
    void read_light(std::span<const cv::Rect> boxes, std::uint16_t* half_rgba, float* depth_m) const;

  private:
    void read(std::size_t plane, const cv::Rect& box, void* into) const;

    const GlFunctions& gl_;
    int width_px_, height_px_;
    GLuint framebuffer_ = 0;
    GLuint textures_[4] = {};
};

}  // namespace atropos::render
