#pragma once

#include <map>
#include <memory>

#include "render/ray_caster.hpp"
#include "render/scene_program.hpp"
#include "render/stereo_frame.hpp"

namespace atropos::render {

/// Which samples an eye sees. A sample is hidden when its viewing ray enters a front face more than the
/// thread's radius before it, or passes within the radius of a part of a thread more than six radii of arc
/// length away.
class VisibilityTest {
  public:
    std::vector<SampleView> views(const FrameInput& input, const Eye& eye);

    void forget_meshes_unused_for(int frames);

  private:
    struct Entry {
        std::shared_ptr<const scenes::TriangleMesh> mesh;
        std::unique_ptr<RayCaster> caster;
        int unused = 0;
    };
    const RayCaster& caster(const std::shared_ptr<const scenes::TriangleMesh>& mesh);

    std::map<const scenes::TriangleMesh*, Entry> casters_;
};

}  // namespace atropos::render
