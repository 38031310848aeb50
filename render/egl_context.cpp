#include <array>
#include <stdexcept>

#include "render/osmesa_context.hpp"
#include "render/shared_library.hpp"
#include "scenes/file_error.hpp"

namespace atropos::render {
namespace {

// The few names of EGL 1.5 that we need, so that its development package is not.
using Handle = void*;
using Proc = void (*)();
constexpr unsigned kSurfacelessPlatform = 0x31DD, kOpenGlApi = 0x30A2;
constexpr int kNone = 0x3038, kMajor = 0x3098, kMinor = 0x30FB, kProfileMask = 0x30FD, kCoreProfile = 1;

class EglContext final : public OffscreenContext {
  public:
    EglContext() : library_("libEGL.so.1", "libegl1") {
        display_ = library_.get<Handle(unsigned, Handle, const std::intptr_t*)>("eglGetPlatformDisplay")(
            kSurfacelessPlatform, nullptr, nullptr);
        int major = 0, minor = 0;
        if (!display_ ||
            !library_.get<unsigned(Handle, int*, int*)>("eglInitialize")(display_, &major, &minor)) {
            throw scenes::FileError("libEGL.so.1",
                                    "has no surfaceless display, expected Mesa's libegl-mesa0");
        }
        library_.get<unsigned(unsigned)>("eglBindAPI")(kOpenGlApi);
        const std::array<int, 7> attributes = {kMajor, 3, kMinor, 3, kProfileMask, kCoreProfile, kNone};
        context_ = library_.get<Handle(Handle, Handle, Handle, const int*)>("eglCreateContext")(
            display_, nullptr, nullptr, attributes.data());
        if (!context_) throw scenes::FileError("libEGL.so.1", "makes no context, expected OpenGL 3.3 core");
        make_current_ = library_.get<unsigned(Handle, Handle, Handle, Handle)>("eglMakeCurrent");
        proc_address_ = library_.get<Proc(const char*)>("eglGetProcAddress");
    }

    ~EglContext() override {
        library_.get<unsigned(Handle, Handle)>("eglDestroyContext")(display_, context_);
    }

    const char* name() const override { return "egl"; }

    void make_current() override {
        if (!make_current_(display_, nullptr, nullptr, context_)) {
            throw std::runtime_error("EGL refused to make its context current");
        }
    }

    void release() override { make_current_(display_, nullptr, nullptr, nullptr); }

    void* proc_address(const char* function) const override {
        return reinterpret_cast<void*>(proc_address_(function));
    }

  private:
    SharedLibrary library_;
    Handle display_;  // shared by the process and never terminated: another context may use it
    Handle context_;
    unsigned (*make_current_)(Handle, Handle, Handle, Handle);
    Proc (*proc_address_)(const char*);
};

}  // namespace

std::unique_ptr<OffscreenContext> make_egl_context() {
    return std::make_unique<EglContext>();
}

}  // namespace atropos::render
