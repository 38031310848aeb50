#pragma once

#include <string>

#include "render/gl.hpp"

namespace atropos::render {

/// A linked program; throws std::runtime_error with the driver's log. Needs its context current, also to die.
class ShaderProgram {
  public:
    /// `defines` goes between the version line and both sources.
    ShaderProgram(const GlFunctions& gl, const std::string& defines, const char* vertex,
                  const char* fragment);
    ~ShaderProgram();
    ShaderProgram(const ShaderProgram&) = delete;
    ShaderProgram& operator=(const ShaderProgram&) = delete;

    void use() const { gl_.UseProgram(program_); }
    GLint uniform(const char* name) const { return gl_.GetUniformLocation(program_, name); }

  private:
    GLuint compile(GLenum stage, const std::string& source) const;

    const GlFunctions& gl_;
    GLuint program_;
};

}  // namespace atropos::render
