#pragma once

#include <memory>

#include "render/offscreen_context.hpp"

namespace atropos::render {

std::unique_ptr<OffscreenContext> make_osmesa_context();
std::unique_ptr<OffscreenContext> make_egl_context();

}  // namespace atropos::render
