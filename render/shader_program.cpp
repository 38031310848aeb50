#include "render/shader_program.hpp"

#include <stdexcept>

namespace atropos::render {

ShaderProgram::ShaderProgram(const GlFunctions& gl, const std::string& defines, const char* vertex,
                             const char* fragment)
    : gl_(gl), program_(gl.CreateProgram()) {
    const std::string head = "#version 330 core\n" + defines;
    for (const GLuint shader :
         {compile(GL_VERTEX_SHADER, head + vertex), compile(GL_FRAGMENT_SHADER, head + fragment)}) {
        gl_.AttachShader(program_, shader);
        gl_.DeleteShader(shader);
    }
    gl_.LinkProgram(program_);
    GLint linked = 0;
    gl_.GetProgramiv(program_, GL_LINK_STATUS, &linked);
    if (!linked) {
        std::string log(1024, '\0');
        gl_.GetProgramInfoLog(program_, static_cast<GLsizei>(log.size()), nullptr, log.data());
        throw std::runtime_error("shader doesn't link: " + std::string(log.c_str()));
    }
}

ShaderProgram::~ShaderProgram() {
    gl_.DeleteProgram(program_);
}

GLuint ShaderProgram::compile(GLenum stage, const std::string& source) const {
    const GLuint shader = gl_.CreateShader(stage);
    const char* text = source.c_str();
    gl_.ShaderSource(shader, 1, &text, nullptr);
    gl_.CompileShader(shader);
    GLint compiled = 0;
    gl_.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (!compiled) {
        std::string log(1024, '\0');
        gl_.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
        throw std::runtime_error("shader doesn't compile: " + std::string(log.c_str()));
    }
    return shader;
}

}  // namespace atropos::render
