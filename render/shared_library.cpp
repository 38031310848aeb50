#include "render/shared_library.hpp"

#include <dlfcn.h>

#include <stdexcept>

namespace atropos::render {

SharedLibrary::SharedLibrary(const char* file, const char* package)
    : file_(file), handle_(dlopen(file, RTLD_NOW | RTLD_LOCAL)) {
    if (!handle_) {
        throw std::runtime_error("cannot load " + file_ + " for off-screen rendering, expected package " +
                                 package + " to be installed");
    }
}

// Never closed: Mesa and LLVM leave threads and exit handlers behind that would point into unmapped code.
SharedLibrary::~SharedLibrary() = default;

void* SharedLibrary::address(const char* symbol) const {
    void* found = dlsym(handle_, symbol);
    if (!found) throw std::runtime_error(file_ + " has no function " + symbol + ", expected Mesa's library");
    return found;
}

}  // namespace atropos::render
