#pragma once

#include <memory>
#include <string>

#include "render/endoscope_options.hpp"
#include "render/stereo_frame.hpp"
#include "render/texture.hpp"
#include "scenes/stereo_rig.hpp"

namespace atropos::render {

/// The stereo endoscope: pictures in linear light and their truth, off screen. The same input gives the same
/// bytes whatever was drawn before and however many threads draw. Not for use from two threads at once;
/// several endoscopes in several threads are fine.
///
///     StereoEndoscope endoscope(endoscope_preset("fast"), scenes::rig_preset("paper").rig);
///     const StereoFrame frame = endoscope.render({.X_WC = X_WC, .items = items, .ribbons = ribbons});
class StereoEndoscope {
  public:
    /// Both cameras must have one size. Throws std::invalid_argument for options or rigs out of range,
    /// scenes::FileError when there is no renderer.
    StereoEndoscope(const EndoscopeOptions& options, const scenes::StereoRig& rig);
    ~StereoEndoscope();
    StereoEndoscope(StereoEndoscope&&) noexcept;

    /// Lets materials name an image made by the program; other names are files.
    void add_texture(const std::string& name, const Texture& texture);

    StereoFrame render(const FrameInput& input);

    /// Back end, renderer and version, to stand beside golden images.
    std::string description() const;

    const scenes::StereoRig& rig() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace atropos::render
