#include "render/offscreen_context.hpp"

#include <cstdlib>
#include <stdexcept>
#include <string_view>

#include "render/osmesa_context.hpp"
#include "scenes/file_error.hpp"

namespace atropos::render {
namespace {

Backend chosen_backend() {
    const char* variable = std::getenv("ATROPOS_RENDERER");
    if (!variable || !*variable) return Backend::kAutomatic;
    const std::string_view value = variable;
    if (value == "osmesa") return Backend::kOSMesa;
    if (value == "egl") return Backend::kEgl;
    throw std::invalid_argument("ATROPOS_RENDERER is '" + std::string(value) + "', expected osmesa or egl");
}

/// llvmpipe's own threads cost a third more CPU time than they save: a program that draws while it tracks and
/// simulates is better off without them. LP_NUM_THREADS, when set, is respected.
void draw_in_the_callers_thread() {
    static const bool once = [] { return setenv("LP_NUM_THREADS", "0", 0) == 0; }();
    static_cast<void>(once);
}

}  // namespace

std::unique_ptr<OffscreenContext> OffscreenContext::create(Backend backend) {
    draw_in_the_callers_thread();
    if (backend == Backend::kAutomatic) backend = chosen_backend();
    if (backend == Backend::kOSMesa) return make_osmesa_context();
    if (backend == Backend::kEgl) return make_egl_context();
    std::string first_reason;
    try {
        return make_osmesa_context();
    } catch (const scenes::FileError& error) {
        first_reason = error.what();
    }
    try {
        return make_egl_context();
    } catch (const scenes::FileError& error) {
        throw scenes::FileError(first_reason, error.what());
    }
}

}  // namespace atropos::render
