#include "render/osmesa_context.hpp"

#include <array>
#include <stdexcept>

#include "render/shared_library.hpp"
#include "scenes/file_error.hpp"

namespace atropos::render {
namespace {

// GL/osmesa.h includes GL/gl.h, which clashes with the core profile's header: the few names we need,
// ourselves.
using Context = struct osmesa_context*;
using Proc = void (*)();
constexpr int kFormat = 0x22, kProfile = 0x33, kCoreProfile = 0x34, kMajor = 0x36, kMinor = 0x37;
constexpr int kRgba = 0x1908, kUnsignedByte = 0x1401, kSize = 16;

class OSMesaContext final : public OffscreenContext {
  public:
    OSMesaContext() : library_("libOSMesa.so.8", "libosmesa6") {
        const std::array<int, 9> attributes = {kFormat, kRgba, kProfile, kCoreProfile, kMajor, 3,
                                               kMinor,  3,     0};
        context_ = library_.get<Context(const int*, Context)>("OSMesaCreateContextAttribs")(attributes.data(),
                                                                                            nullptr);
        if (!context_)
            throw scenes::FileError("libOSMesa.so.8", "makes no context, expected OpenGL 3.3 core");
        make_current_ = library_.get<unsigned char(Context, void*, unsigned, int, int)>("OSMesaMakeCurrent");
        proc_address_ = library_.get<Proc(const char*)>("OSMesaGetProcAddress");
    }

    ~OSMesaContext() override { library_.get<void(Context)>("OSMesaDestroyContext")(context_); }

    const char* name() const override { return "osmesa"; }

    void make_current() override {
        if (!make_current_(context_, pixels_.data(), kUnsignedByte, kSize, kSize)) {
            throw std::runtime_error("OSMesa refused to make its context current");
        }
    }

    void release() override { make_current_(nullptr, nullptr, 0, 0, 0); }

    void* proc_address(const char* function) const override {
        return reinterpret_cast<void*>(proc_address_(function));
    }

  private:
    SharedLibrary library_;
    Context context_;
    unsigned char (*make_current_)(Context, void*, unsigned, int, int);
    Proc (*proc_address_)(const char*);
    std::array<unsigned char, 4 * kSize * kSize> pixels_{};  // all drawing goes to framebuffer objects
};

}  // namespace

std::unique_ptr<OffscreenContext> make_osmesa_context() {
    return std::make_unique<OSMesaContext>();
}

}  // namespace atropos::render
