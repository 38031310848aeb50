#pragma once

#include "render/thread_ribbon.hpp"
#include "scenes/triangle_mesh.hpp"

namespace atropos::render {

/// The thread's body as triangles in W, `sides` around, without caps: for its shadow, and for other
/// renderers.
scenes::TriangleMesh thread_tube(const ThreadRibbon& ribbon, int sides = 8);

}  // namespace atropos::render
