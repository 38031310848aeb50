#include "render/stereo_endoscope.hpp"

#include <stdexcept>

#include "render/ribbon_painter.hpp"
#include "render/scene_renderer.hpp"
#include "render/visibility.hpp"
#include "scenes/worker_pool.hpp"

namespace atropos::render {
namespace {

constexpr int kFramesToKeepCasters = 400;

void validate(const EndoscopeOptions& options, const scenes::StereoRig& rig) {
    const auto require = [](bool good, const std::string& message) {
        if (!good) throw std::invalid_argument(message);
    };
    require(options.supersampling == 1 || options.supersampling == 2,
            "supersampling is " + std::to_string(options.supersampling) + ", expected 1 or 2");
    require(options.near_m > 0.0 && options.far_m > options.near_m,
            "near and far are " + std::to_string(options.near_m) + " and " + std::to_string(options.far_m) +
                " m, expected 0 < near < far");
    const scenes::Camera &l = rig.left, &r = rig.right;
    require(l.width_px == r.width_px && l.height_px == r.height_px,
            "the two cameras differ in size, expected one size");
    require(l.width_px >= 8 && l.height_px >= 8 && 2 * l.width_px * options.supersampling <= 16384 &&
                l.height_px * options.supersampling <= 16384,
            "images are " + std::to_string(l.width_px) + "x" + std::to_string(l.height_px) +
                " pixels, expected 8x8 to 16384 samples for both eyes");
    require(l.fx_px > 0.0 && l.fy_px > 0.0 && r.fx_px > 0.0 && r.fy_px > 0.0,
            "a focal length isn't positive, expected pixels");
}

}  // namespace

struct StereoEndoscope::Impl {
    Impl(const EndoscopeOptions& o, const scenes::StereoRig& r)
        : options(o),
          rig(r),
          eyes{{{r.left, Eigen::Isometry3d::Identity(), 0}, {r.right, r.X_RC, 1}}},
          scene(o, r),
          pool(o.threads) {}

    EyeFrame eye_frame(const FrameInput& input, const Eye& eye, const SceneLayers& layers);

    EndoscopeOptions options;
    scenes::StereoRig rig;
    std::array<Eye, 2> eyes;
    SceneRenderer scene;
    std::array<EyeScene, 2> scenes;
    VisibilityTest visibility;
    scenes::WorkerPool pool;
};

EyeFrame StereoEndoscope::Impl::eye_frame(const FrameInput& input, const Eye& eye,
                                          const SceneLayers& layers) {
    const scenes::Camera& camera = eye.camera;
    const EyeSamples samples{layers, eye.index * layers.width / 2, options.supersampling, camera.width_px,
                             camera.height_px};
    const double sigma_px = options.psf_sigma_px(camera.width_px);
    EyeFrame frame;
    const auto e = static_cast<std::size_t>(eye.index);
    for (const cv::Rect& box : layers.changed[e]) update(scenes[e], samples, sigma_px, box);
    frame.linear = scenes[e].linear.clone();
    frame.depth_m = scenes[e].depth_m.clone();
    frame.labels = scenes[e].labels.clone();
    frame.coverage = cv::Mat::zeros(camera.height_px, camera.width_px, CV_32F);
    const EyeLight light{input.light, eye.X_EC * light_position_C(input.light, rig),
                         eye.X_EC.linear() * light_axis_C(rig)};
    paint_ribbons(input.ribbons, eye, eye.X_EC * input.X_WC.inverse(), light, samples, sigma_px, frame.linear,
                  frame.coverage);
    frame.labels.setTo(static_cast<int>(scenes::Label::kThread), frame.coverage >= 0.5);
    return frame;
}

StereoEndoscope::StereoEndoscope(const EndoscopeOptions& options, const scenes::StereoRig& rig) {
    validate(options, rig);
    impl_ = std::make_unique<Impl>(options, rig);
}

StereoEndoscope::~StereoEndoscope() = default;
StereoEndoscope::StereoEndoscope(StereoEndoscope&&) noexcept = default;

void StereoEndoscope::add_texture(const std::string& name, const Texture& texture) {
    impl_->scene.add_texture(name, texture);
}

StereoFrame StereoEndoscope::render(const FrameInput& input) {
    const SceneLayers& layers = impl_->scene.draw(input);
    const std::array<Eye, 2>& eyes = impl_->eyes;
    std::array<EyeFrame, 2> frames;
    std::array<std::vector<SampleView>, 2> samples;
    // The samples' lookup shares its casters between the eyes: one task.
    impl_->pool.run(3, [&](int task) {
        if (task < 2) {
            const auto eye = static_cast<std::size_t>(task);
            frames[eye] = impl_->eye_frame(input, eyes[eye], layers);
        } else {
            for (std::size_t eye = 0; eye < 2; ++eye)
                samples[eye] = impl_->visibility.views(input, eyes[eye]);
        }
    });
    StereoFrame frame{std::move(frames[0]), std::move(frames[1])};
    frame.left.samples = std::move(samples[0]);
    frame.right.samples = std::move(samples[1]);
    impl_->visibility.forget_meshes_unused_for(kFramesToKeepCasters);
    return frame;
}

std::string StereoEndoscope::description() const {
    return impl_->scene.description();
}

const scenes::StereoRig& StereoEndoscope::rig() const {
    return impl_->rig;
}

}  // namespace atropos::render
