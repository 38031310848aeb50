#pragma once

#include <memory>
#include <span>

#include "scenes/render_item.hpp"
#include "scenes/stereo_rig.hpp"

namespace atropos::experiments {

/// MuJoCo's renderer on the same OSMesa, meshes, poses and cameras: lit by vertex in OpenGL's fixed pipeline,
/// colour and depth of both eyes side by side, no textures, labels or thread.
class MujocoPeer {
  public:
    MujocoPeer(std::span<const scenes::RenderItem> items, const scenes::StereoRig& rig,
               const Eigen::Isometry3d& X_WC);
    ~MujocoPeer();

    /// Draws and reads back.
    void draw();

    /// Of the last drawing, rows from the top: z in the eye's frame.
    float depth_m(int eye, int x, int y) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace atropos::experiments
