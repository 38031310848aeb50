#pragma once

#include <GL/glcorearb.h>

namespace atropos::render {

class OffscreenContext;

// clang-format off
#define ATROPOS_GL_FUNCTIONS(X)                                                                              \
    X(GETSTRING, GetString) X(GETINTEGERV, GetIntegerv) X(GETERROR, GetError) X(ENABLE, Enable)             \
    X(DISABLE, Disable) X(CULLFACE, CullFace) X(DEPTHFUNC, DepthFunc) X(DEPTHMASK, DepthMask)                \
    X(VIEWPORT, Viewport) X(SCISSOR, Scissor) X(CLEARBUFFERFV, ClearBufferfv) X(CLEARBUFFERUIV, ClearBufferuiv) \
    X(GENTEXTURES, GenTextures) X(DELETETEXTURES, DeleteTextures) X(BINDTEXTURE, BindTexture)                \
    X(ACTIVETEXTURE, ActiveTexture) X(TEXIMAGE2D, TexImage2D) X(TEXPARAMETERI, TexParameteri)                \
    X(GENERATEMIPMAP, GenerateMipmap) X(GENBUFFERS, GenBuffers) X(DELETEBUFFERS, DeleteBuffers)              \
    X(BINDBUFFER, BindBuffer) X(BUFFERDATA, BufferData) X(GENVERTEXARRAYS, GenVertexArrays)                  \
    X(DELETEVERTEXARRAYS, DeleteVertexArrays) X(BINDVERTEXARRAY, BindVertexArray)                            \
    X(ENABLEVERTEXATTRIBARRAY, EnableVertexAttribArray) X(VERTEXATTRIBPOINTER, VertexAttribPointer)          \
    X(GENFRAMEBUFFERS, GenFramebuffers) X(DELETEFRAMEBUFFERS, DeleteFramebuffers)                            \
    X(BINDFRAMEBUFFER, BindFramebuffer) X(FRAMEBUFFERTEXTURE2D, FramebufferTexture2D)                        \
    X(CHECKFRAMEBUFFERSTATUS, CheckFramebufferStatus) X(DRAWBUFFERS, DrawBuffers) X(DRAWBUFFER, DrawBuffer)  \
    X(READBUFFER, ReadBuffer) X(READPIXELS, ReadPixels) X(PIXELSTOREI, PixelStorei)                          \
    X(BLITFRAMEBUFFER, BlitFramebuffer) X(CREATESHADER, CreateShader) X(DELETESHADER, DeleteShader)          \
    X(SHADERSOURCE, ShaderSource) X(COMPILESHADER, CompileShader) X(GETSHADERIV, GetShaderiv)                \
    X(GETSHADERINFOLOG, GetShaderInfoLog) X(CREATEPROGRAM, CreateProgram) X(DELETEPROGRAM, DeleteProgram)    \
    X(ATTACHSHADER, AttachShader) X(LINKPROGRAM, LinkProgram) X(GETPROGRAMIV, GetProgramiv)                  \
    X(GETPROGRAMINFOLOG, GetProgramInfoLog) X(USEPROGRAM, UseProgram)                                        \
    X(GETUNIFORMLOCATION, GetUniformLocation) X(UNIFORM1I, Uniform1i) X(UNIFORM1UI, Uniform1ui)              \
    X(UNIFORM1F, Uniform1f) X(UNIFORM1FV, Uniform1fv) X(UNIFORM2F, Uniform2f) X(UNIFORM3F, Uniform3f)        \
    X(UNIFORM4F, Uniform4f) X(UNIFORMMATRIX3FV, UniformMatrix3fv) X(UNIFORMMATRIX4FV, UniformMatrix4fv)      \
    X(DRAWELEMENTS, DrawElements) X(FINISH, Finish) X(POLYGONOFFSET, PolygonOffset)
// clang-format on

/// OpenGL's functions as one context gives them. A table of our own, because Debian's loaders ask GLX and
/// every program that links libGL before OSMesa calls functions that silently do nothing.
struct GlFunctions {
#define ATROPOS_GL_MEMBER(upper, name) PFNGL##upper##PROC name = nullptr;
    ATROPOS_GL_FUNCTIONS(ATROPOS_GL_MEMBER)
#undef ATROPOS_GL_MEMBER

    /// `context` is current. Throws scenes::FileError when it is older than OpenGL 3.3.
    static GlFunctions load(const OffscreenContext& context);
};

}  // namespace atropos::render
