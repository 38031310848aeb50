#pragma once

#include <memory>
#include <string>

namespace atropos::render {

/// Where the pixels are made. Both draw with Mesa's llvmpipe and give the same bytes.
enum class Backend {
    kAutomatic,  ///< OSMesa, or EGL when libOSMesa is missing; ATROPOS_RENDERER=osmesa|egl overrides
    kOSMesa,
    kEgl,
};

/// An OpenGL 3.3 core context without a window. Libraries are loaded at run time, so that programs which draw
/// nothing start without them.
class OffscreenContext {
  public:
    /// Throws scenes::FileError that says which library or version is missing.
    static std::unique_ptr<OffscreenContext> create(Backend backend);

    virtual ~OffscreenContext() = default;
    OffscreenContext(const OffscreenContext&) = delete;
    OffscreenContext& operator=(const OffscreenContext&) = delete;

    virtual const char* name() const = 0;

    /// Bind to, or release from, the calling thread; a context is bound to at most one thread.
    virtual void make_current() = 0;
    virtual void release() = 0;

    /// Never null: drivers return a stub for unknown names, so ask the version instead.
    virtual void* proc_address(const char* function) const = 0;

  protected:
    OffscreenContext() = default;
};

/// Binds a context for a scope.
class CurrentContext {
  public:
    explicit CurrentContext(OffscreenContext& context) : context_(context) { context_.make_current(); }
    ~CurrentContext() { context_.release(); }
    CurrentContext(const CurrentContext&) = delete;
    CurrentContext& operator=(const CurrentContext&) = delete;

  private:
    OffscreenContext& context_;
};

}  // namespace atropos::render
