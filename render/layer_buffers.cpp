#include "render/layer_buffers.hpp"

#include <array>
#include <stdexcept>
#include <string>

namespace atropos::render {
namespace {

constexpr std::array<GLenum, 3> kTargets = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2};

struct Plane {
    GLint internal_format;
    GLenum format, type, attachment;
};
constexpr std::array<Plane, 4> kPlanes = {
    {{GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, kTargets[0]},
     {GL_R32F, GL_RED, GL_FLOAT, kTargets[1]},
     {GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE, kTargets[2]},
     {GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, GL_DEPTH_ATTACHMENT}}};

}  // namespace

LayerBuffers::LayerBuffers(const GlFunctions& gl, int width_px, int height_px)
    : gl_(gl), width_px_(width_px), height_px_(height_px) {
    gl_.GenFramebuffers(1, &framebuffer_);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    gl_.GenTextures(4, textures_);
    for (std::size_t i = 0; i < kPlanes.size(); ++i) {
        gl_.BindTexture(GL_TEXTURE_2D, textures_[i]);
        gl_.TexImage2D(GL_TEXTURE_2D, 0, kPlanes[i].internal_format, width_px, height_px, 0,
                       kPlanes[i].format, kPlanes[i].type, nullptr);
        gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        gl_.FramebufferTexture2D(GL_FRAMEBUFFER, kPlanes[i].attachment, GL_TEXTURE_2D, textures_[i], 0);
    }
    gl_.DrawBuffers(static_cast<GLsizei>(kTargets.size()), kTargets.data());
    if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
        throw std::runtime_error("no framebuffer of " + std::to_string(width_px) + "x" +
                                 std::to_string(height_px) + " pixels, expected at most 16384 a side");
    }
}

LayerBuffers::~LayerBuffers() {
    gl_.DeleteTextures(4, textures_);
    gl_.DeleteFramebuffers(1, &framebuffer_);
}

void LayerBuffers::bind() const {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
}

void LayerBuffers::clear() const {
    const std::array<float, 4> black = {0.0f, 0.0f, 0.0f, 1.0f}, nothing = {};
    const std::array<GLuint, 4> background = {};
    const float far = 1.0f;
    gl_.ClearBufferfv(GL_COLOR, 0, black.data());
    gl_.ClearBufferfv(GL_COLOR, 1, nothing.data());
    gl_.ClearBufferuiv(GL_COLOR, 2, background.data());
    gl_.ClearBufferfv(GL_DEPTH, 0, &far);
}

void LayerBuffers::copy_from(const LayerBuffers& other, std::span<const cv::Rect> boxes) const {
    gl_.Disable(GL_SCISSOR_TEST);
    gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, other.framebuffer_);
    gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer_);
    for (std::size_t i = 0; i < kTargets.size(); ++i) {
        std::array<GLenum, 3> only = {GL_NONE, GL_NONE, GL_NONE};
        only[i] = kTargets[i];
        gl_.ReadBuffer(kTargets[i]);
        gl_.DrawBuffers(static_cast<GLsizei>(only.size()), only.data());
        const GLbitfield planes = GL_COLOR_BUFFER_BIT | (i == 0 ? GL_DEPTH_BUFFER_BIT : 0u);
        for (const cv::Rect& b : boxes) {
            const int right = b.x + b.width, bottom = b.y + b.height;
            gl_.BlitFramebuffer(b.x, b.y, right, bottom, b.x, b.y, right, bottom, planes, GL_NEAREST);
        }
    }
    gl_.DrawBuffers(static_cast<GLsizei>(kTargets.size()), kTargets.data());
}

void LayerBuffers::read(std::size_t plane, const cv::Rect& box, void* into) const {
    gl_.ReadBuffer(kTargets[plane]);
    gl_.ReadPixels(box.x, box.y, box.width, box.height, kPlanes[plane].format, kPlanes[plane].type, into);
}

void LayerBuffers::read_labels(std::uint8_t* labels) const {
    bind();
    gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl_.PixelStorei(GL_PACK_ROW_LENGTH, width_px_);
    read(2, {0, 0, width_px_, height_px_}, labels);
}

void LayerBuffers::read_light(std::span<const cv::Rect> boxes, std::uint16_t* half_rgba,
                              float* depth_m) const {
    bind();
    gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl_.PixelStorei(GL_PACK_ROW_LENGTH, width_px_);
    for (const cv::Rect& box : boxes) {
        const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(box.y) * width_px_ + box.x;
        read(0, box, half_rgba + 4 * first);
        read(1, box, depth_m + first);
    }
}

}  // namespace atropos::render
