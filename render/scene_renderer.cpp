#include "render/scene_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "render/shadow_map.hpp"
#include "render/thread_tube.hpp"

namespace atropos::render {
namespace {

constexpr double kMaxEdgeUnderDistortion_m = 0.0012;  // bends by < 0.005 px at 640 wide, k1 = -0.12
constexpr std::int64_t kFramesToKeepMeshes = 200;
const std::string kWhite = "*white", kFlat = "*flat";  // for materials without textures

// llvmpipe reads plain bytes several times faster than sRGB; a square root codes light nearly as well, and
// the shader undoes it by one multiplication.
std::vector<std::uint8_t> with_square_root_code(std::vector<std::uint8_t> rgba) {
    std::array<std::uint8_t, 256> code;
    for (std::size_t i = 0; i < code.size(); ++i) {
        const double v = static_cast<double>(i) / 255.0;
        const double linear = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
        code[i] = static_cast<std::uint8_t>(std::lround(255.0 * std::sqrt(linear)));
    }
    for (std::size_t i = 0; i < rgba.size(); ++i) {
        if (i % 4 != 3) rgba[i] = code[rgba[i]];
    }
    return rgba;
}

bool equal(const Light& a, const Light& b) {
    return a.offset_m == b.offset_m && a.intensity == b.intensity && a.reference_m == b.reference_m &&
           a.cos_inner == b.cos_inner && a.cos_outer == b.cos_outer && a.ambient == b.ambient;
}

bool equal(const scenes::Material& a, const scenes::Material& b) {
    return a.base_colour == b.base_colour && a.metallic == b.metallic && a.roughness == b.roughness &&
           a.specular_f0 == b.specular_f0 && a.wetness == b.wetness && a.colour_texture == b.colour_texture &&
           a.normal_texture == b.normal_texture;
}

bool equal(const scenes::RenderItem& a, const scenes::RenderItem& b) {
    return a.mesh == b.mesh && a.X_WM.matrix() == b.X_WM.matrix() && equal(a.material, b.material) &&
           a.label == b.label;
}

// Whether each pixel that an item in motion covers has a label of its own.
bool is_told_by_labels(std::span<const scenes::RenderItem> items) {
    std::array<bool, 256> rests{};  // and the background
    rests[0] = true;
    const auto at = [](const scenes::RenderItem& item) { return static_cast<std::size_t>(item.label); };
    for (const scenes::RenderItem& item : items) rests[at(item)] |= item.at_rest;
    return std::none_of(items.begin(), items.end(),
                        [&](const auto& item) { return !item.at_rest && rests[at(item)]; });
}

}  // namespace

SceneRenderer::SceneRenderer(const EndoscopeOptions& options, const scenes::StereoRig& rig)
    : options_(options), rig_(rig), context_(OffscreenContext::create(options.backend)) {
    const CurrentContext current(*context_);
    gl_ = GlFunctions::load(*context_);
    layers_.width = 2 * rig.left.width_px * options.supersampling;
    layers_.height = rig.left.height_px * options.supersampling;
    const std::size_t samples =
        static_cast<std::size_t>(layers_.width) * static_cast<std::size_t>(layers_.height);
    layers_.half_rgba.resize(4 * samples);
    layers_.depth_m.resize(samples);
    layers_.labels.resize(samples);
    frame_ = std::make_unique<LayerBuffers>(gl_, layers_.width, layers_.height);
    if (options.shadows) shadow_map_ = std::make_unique<ShadowMap>(gl_);
}

SceneRenderer::~SceneRenderer() {
    const CurrentContext current(*context_);
    for (const auto& [name, id] : textures_) gl_.DeleteTextures(1, &id);
    textures_.clear();
    meshes_.clear();
    programs_.clear();
    shadow_map_.reset();
    at_rest_.reset();
    frame_.reset();
}

const SceneLayers& SceneRenderer::draw(const FrameInput& input) {
    const CurrentContext current(*context_);
    ++frame_count_;
    gl_.Enable(GL_DEPTH_TEST);
    gl_.Enable(GL_CULL_FACE);
    gl_.CullFace(GL_FRONT);  // images are upside down for OpenGL, which mirrors the winding
    if (shadow_map_) draw_shadows(input);

    const bool may_cache =
        options_.cache_layer_at_rest && !shadow_map_ &&
        std::any_of(input.items.begin(), input.items.end(), [](auto& i) { return i.at_rest; });
    if (may_cache && is_cached(input)) {
        draw_over_rest(input);
    } else if (may_cache && has_last_camera_ && last_X_WC_.matrix() == input.X_WC.matrix()) {
        if (!at_rest_) at_rest_ = std::make_unique<LayerBuffers>(gl_, layers_.width, layers_.height);
        clear(*at_rest_);
        draw_items(input, true);
        remember(input);
        draw_over_rest(input);
    } else {
        // Nearest first saves shading. Ties of depth go to the items at rest, as they do above.
        clear(*frame_);
        draw_items(input, false);
        draw_items(input, true);
        read_all();
    }
    has_last_camera_ = true;
    last_X_WC_ = input.X_WC;
    if (frame_count_ % kFramesToKeepMeshes == 0) forget_old_meshes();
    return layers_;
}

void SceneRenderer::draw_over_rest(const FrameInput& input) {
    std::vector<cv::Rect> stale;
    for (const auto& [key, box] : drawn_over_rest_) stale.push_back(box);
    frame_->copy_from(*at_rest_, stale);
    frame_->bind();
    draw_items(input, false);
    if (!is_told_by_labels(input.items)) return read_all();
    frame_->read_labels(layers_.labels.data());
    LabelBoxes drawn = boxes_of_changes(layers_.labels, labels_at_rest_, layers_.width);
    layers_.changed = by_eye(drawn_over_rest_, drawn);
    for (const auto& boxes : layers_.changed)
        frame_->read_light(boxes, layers_.half_rgba.data(), layers_.depth_m.data());
    drawn_over_rest_ = std::move(drawn);
}

void SceneRenderer::read_all() {
    const int half = layers_.width / 2;
    drawn_over_rest_ = {{{0, 0}, {0, 0, half, layers_.height}}, {{1, 0}, {half, 0, half, layers_.height}}};
    layers_.changed = by_eye(drawn_over_rest_, {});
    frame_->read_labels(layers_.labels.data());
    for (const auto& boxes : layers_.changed)
        frame_->read_light(boxes, layers_.half_rgba.data(), layers_.depth_m.data());
}

void SceneRenderer::clear(const LayerBuffers& buffers) const {
    gl_.Disable(GL_SCISSOR_TEST);
    buffers.bind();
    buffers.clear();
}

void SceneRenderer::draw_shadows(const FrameInput& input) {
    X_SC_ = ShadowMap::projection(light_position_C(input.light, rig_), light_axis_C(rig_));
    const Eigen::Isometry3d X_CW = input.X_WC.inverse();
    std::vector<std::unique_ptr<GpuMesh>> tubes;
    for (const scenes::RenderItem& item : input.items) gpu_mesh(item);
    for (const ThreadRibbon& ribbon : input.ribbons) {
        tubes.push_back(std::make_unique<GpuMesh>(gl_, thread_tube(ribbon), 0.0));
    }
    gl_.DepthFunc(GL_LESS);
    gl_.Disable(GL_CULL_FACE);
    shadow_map_->begin();
    for (const scenes::RenderItem& item : input.items) {
        shadow_map_->set_pose(X_SC_ * (X_CW * item.X_WM).matrix());
        gpu_mesh(item).draw();
    }
    shadow_map_->set_pose(X_SC_ * X_CW.matrix());
    for (const auto& tube : tubes) tube->draw();
    gl_.Enable(GL_CULL_FACE);
}

void SceneRenderer::draw_items(const FrameInput& input, bool at_rest) {
    gl_.DepthFunc(at_rest ? GL_LEQUAL : GL_LESS);
    const std::array<Eye, 2> eyes = {
        {{rig_.left, Eigen::Isometry3d::Identity(), 0}, {rig_.right, rig_.X_RC, 1}}};
    const int half = layers_.width / 2;
    gl_.Enable(GL_SCISSOR_TEST);
    for (const Eye& eye : eyes) {
        gl_.Viewport(eye.index * half, 0, half, layers_.height);
        gl_.Scissor(eye.index * half, 0, half, layers_.height);
        const SceneProgram* active = nullptr;
        for (const scenes::RenderItem& item : input.items) {
            if (item.at_rest != at_rest) continue;
            const GpuMesh& mesh = gpu_mesh(item);
            const SceneProgram& program = program_for(item, eye);
            if (&program != active) {
                program.use();
                program.set_eye(eye, options_);
                program.set_light(input.light, rig_, eye, X_SC_);
                active = &program;
            }
            bind_textures(item.material);
            program.set_item(item, eye.X_EC * input.X_WC.inverse() * item.X_WM);
            mesh.draw();
        }
    }
}

const SceneProgram& SceneRenderer::program_for(const scenes::RenderItem& item, const Eye& eye) {
    unsigned variant = 0;
    if (!item.material.colour_texture.empty() || !item.material.normal_texture.empty()) {
        variant |= SceneProgram::kTextured;
    }
    if (item.material.wetness > 0.0f) variant |= SceneProgram::kWet;
    if (shadow_map_) variant |= SceneProgram::kShadows;
    if (eye.camera.is_distorted()) variant |= SceneProgram::kDistorted;
    auto& program = programs_[variant];
    if (!program) program = std::make_unique<SceneProgram>(gl_, variant);
    return *program;
}

void SceneRenderer::bind_textures(const scenes::Material& material) {
    gl_.ActiveTexture(GL_TEXTURE0);
    gl_.BindTexture(GL_TEXTURE_2D, texture(material.colour_texture, true));
    gl_.ActiveTexture(GL_TEXTURE1);
    gl_.BindTexture(GL_TEXTURE_2D, texture(material.normal_texture, false));
    if (shadow_map_) {
        gl_.ActiveTexture(GL_TEXTURE2);
        gl_.BindTexture(GL_TEXTURE_2D, shadow_map_->texture());
    }
    gl_.ActiveTexture(GL_TEXTURE0);
}

bool SceneRenderer::is_cached(const FrameInput& input) const {
    if (!has_cached_layer_ || cached_X_WC_.matrix() != input.X_WC.matrix() ||
        !equal(cached_light_, input.light)) {
        return false;
    }
    auto cached = cached_items_.begin();
    for (const scenes::RenderItem& item : input.items) {
        if (!item.at_rest) continue;
        if (cached == cached_items_.end() || !equal(*cached++, item)) return false;
    }
    return cached == cached_items_.end();
}

void SceneRenderer::remember(const FrameInput& input) {
    labels_at_rest_.resize(layers_.labels.size());
    at_rest_->read_labels(labels_at_rest_.data());
    has_cached_layer_ = true;
    cached_X_WC_ = input.X_WC;
    cached_light_ = input.light;
    cached_items_.clear();
    for (const scenes::RenderItem& item : input.items) {
        if (item.at_rest) cached_items_.push_back(item);
    }
}

const GpuMesh& SceneRenderer::gpu_mesh(const scenes::RenderItem& item) {
    if (!item.mesh) throw std::invalid_argument("a render item has no mesh, expected one");
    CachedMesh& cached = meshes_[item.mesh.get()];
    if (!cached.gpu) {
        const bool is_distorted = rig_.left.is_distorted() || rig_.right.is_distorted();
        cached.source = item.mesh;
        cached.gpu =
            std::make_unique<GpuMesh>(gl_, *item.mesh, is_distorted ? kMaxEdgeUnderDistortion_m : 0.0);
    }
    cached.last_frame = frame_count_;
    return *cached.gpu;
}

void SceneRenderer::forget_old_meshes() {
    std::erase_if(meshes_, [this](const auto& entry) {
        return entry.second.last_frame + kFramesToKeepMeshes < frame_count_;
    });
}

void SceneRenderer::add_texture(const std::string& name, const Texture& texture) {
    const CurrentContext current(*context_);
    upload(name, texture);
    has_cached_layer_ = false;
}

GLuint SceneRenderer::texture(const std::string& name, bool is_colour) {
    const auto found = textures_.find(name.empty() ? (is_colour ? kWhite : kFlat) : name);
    if (found != textures_.end()) return found->second;
    if (!name.empty()) return upload(name, load_texture(name, is_colour));
    if (is_colour) return upload(kWhite, {1, 1, true, {255, 255, 255, 255}});
    return upload(kFlat, {1, 1, false, {128, 128, 255, 255}});
}

GLuint SceneRenderer::upload(const std::string& name, const Texture& texture) {
    const std::size_t expected =
        4 * static_cast<std::size_t>(texture.width_px) * static_cast<std::size_t>(texture.height_px);
    if (texture.rgba.size() != expected || expected == 0) {
        throw std::invalid_argument("texture '" + name + "' has " + std::to_string(texture.rgba.size()) +
                                    " bytes, expected 4 a pixel: " + std::to_string(expected));
    }
    GLuint& id = textures_[name];
    if (id == 0) gl_.GenTextures(1, &id);
    gl_.BindTexture(GL_TEXTURE_2D, id);
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, texture.width_px, texture.height_px, 0, GL_RGBA,
                   GL_UNSIGNED_BYTE,
                   (texture.is_colour ? with_square_root_code(texture.rgba) : texture.rgba).data());
    gl_.GenerateMipmap(GL_TEXTURE_2D);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER,
                      GL_LINEAR_MIPMAP_NEAREST);  // half the cost of trilinear
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    return id;
}

std::string SceneRenderer::description() const {
    const CurrentContext current(*context_);
    const auto text = [this](GLenum name) { return reinterpret_cast<const char*>(gl_.GetString(name)); };
    return std::string(context_->name()) + "; " + text(GL_RENDERER) + "; " + text(GL_VERSION);
}

}  // namespace atropos::render
