#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "render/changed_boxes.hpp"
#include "render/endoscope_options.hpp"
#include "render/gpu_mesh.hpp"
#include "render/layer_buffers.hpp"
#include "render/scene_program.hpp"
#include "render/stereo_frame.hpp"
#include "render/texture.hpp"
#include "scenes/stereo_rig.hpp"

namespace atropos::render {

class ShadowMap;

/// Samples of both eyes side by side, as the framebuffer holds them.
struct SceneLayers {
    int width = 0;  ///< samples in a row, both eyes
    int height = 0;
    std::vector<std::uint16_t> half_rgba;
    std::vector<float> depth_m;
    std::vector<std::uint8_t> labels;
    std::array<std::vector<cv::Rect>, 2> changed;  ///< by eye, all that may differ from the frame before
};

/// Draws the items of a frame (not the threads) for both eyes into one framebuffer.
class SceneRenderer {
  public:
    SceneRenderer(const EndoscopeOptions& options, const scenes::StereoRig& rig);
    ~SceneRenderer();

    void add_texture(const std::string& name, const Texture& texture);

    /// Valid until the next call.
    const SceneLayers& draw(const FrameInput& input);

    /// Back end, GL_RENDERER and GL_VERSION: what golden images depend on.
    std::string description() const;

  private:
    struct CachedMesh {
        std::shared_ptr<const scenes::TriangleMesh> source;  // kept, so that its address stays its own
        std::unique_ptr<GpuMesh> gpu;
        std::int64_t last_frame;
    };

    void draw_over_rest(const FrameInput& input);
    void read_all();
    void clear(const LayerBuffers& buffers) const;
    void draw_shadows(const FrameInput& input);
    void draw_items(const FrameInput& input, bool at_rest);
    const SceneProgram& program_for(const scenes::RenderItem& item, const Eye& eye);
    void bind_textures(const scenes::Material& material);
    bool is_cached(const FrameInput& input) const;
    void remember(const FrameInput& input);
    const GpuMesh& gpu_mesh(const scenes::RenderItem& item);
    GLuint texture(const std::string& name, bool is_colour);
    GLuint upload(const std::string& name, const Texture& texture);
    void forget_old_meshes();

    EndoscopeOptions options_;
    scenes::StereoRig rig_;
    std::unique_ptr<OffscreenContext> context_;
    GlFunctions gl_;
    std::unique_ptr<LayerBuffers> frame_, at_rest_;
    std::unique_ptr<ShadowMap> shadow_map_;
    std::map<unsigned, std::unique_ptr<SceneProgram>> programs_;  // by variant
    std::map<const scenes::TriangleMesh*, CachedMesh> meshes_;
    std::map<std::string, GLuint> textures_;
    SceneLayers layers_;
    std::int64_t frame_count_ = 0;
    Eigen::Matrix4d X_SC_ = Eigen::Matrix4d::Identity();  // left camera to the shadow map's clip space
    bool has_last_camera_ = false;                        // one frame seen: a camera seen twice is at rest
    Eigen::Isometry3d last_X_WC_ = Eigen::Isometry3d::Identity();
    bool has_cached_layer_ = false;
    Eigen::Isometry3d cached_X_WC_ = Eigen::Isometry3d::Identity();
    Light cached_light_;
    std::vector<scenes::RenderItem> cached_items_;
    std::vector<std::uint8_t> labels_at_rest_;
    LabelBoxes drawn_over_rest_;  // where the frame differs from the layer at rest
};

}  // namespace atropos::render
