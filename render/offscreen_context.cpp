#include "render/offscreen_context.hpp"

#include <cstdlib>
#include <stdexcept>
#include <string_view>

#include "render/osmesa_context.hpp"

namespace atropos::render {
namespace {

Backend chosen_backend() {
    const char* variable = std::getenv("ATROPOS_RENDERER");
    if (!variable || !*variable) return Backend::kAutomatic;
    const std::string_view value = variable;
    if (value == "osmesa") return Backend::kOSMesa;
    if (value == "egl") return Backend::kEgl;
    throw std::runtime_error("ATROPOS_RENDERER is '" + std::string(value) + "', expected osmesa or egl");
}

}  // namespace

std::unique_ptr<OffscreenContext> OffscreenContext::create(Backend backend) {
    if (backend == Backend::kAutomatic) backend = chosen_backend();
    if (backend == Backend::kOSMesa) return make_osmesa_context();
    if (backend == Backend::kEgl) return make_egl_context();
    std::string first_reason;
    try {
        return make_osmesa_context();
    } catch (const std::runtime_error& error) {
        first_reason = error.what();
    }
    try {
        return make_egl_context();
    } catch (const std::runtime_error& error) {
        throw std::runtime_error(first_reason + "; " + error.what());
    }
}

}  // namespace atropos::render
