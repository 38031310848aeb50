#include "render/gl.hpp"

#include <stdexcept>
#include <string>

#include "render/offscreen_context.hpp"
#include "scenes/file_error.hpp"

namespace atropos::render {

GlFunctions GlFunctions::load(const OffscreenContext& context) {
    GlFunctions gl;
#define ATROPOS_GL_LOAD(upper, name) \
    gl.name = reinterpret_cast<PFNGL##upper##PROC>(context.proc_address("gl" #name));
    ATROPOS_GL_FUNCTIONS(ATROPOS_GL_LOAD)
#undef ATROPOS_GL_LOAD
    GLint major = 0, minor = 0;
    gl.GetIntegerv(GL_MAJOR_VERSION, &major);
    gl.GetIntegerv(GL_MINOR_VERSION, &minor);
    if (10 * major + minor < 33) {
        throw scenes::FileError(context.name(), "gives OpenGL " + std::to_string(major) + "." +
                                                    std::to_string(minor) + ", expected 3.3 or newer");
    }
    return gl;
}

}  // namespace atropos::render
