#include "render/shared_library.hpp"

#include <dlfcn.h>

#include "scenes/file_error.hpp"

namespace atropos::render {

SharedLibrary::SharedLibrary(const char* file, const char* package)
    : file_(file), handle_(dlopen(file, RTLD_NOW | RTLD_LOCAL)) {
    if (!handle_) {
        throw scenes::FileError(file_, "cannot be loaded for off-screen rendering, expected package " +
                                           std::string(package) + " to be installed");
    }
}

// Never closed: Mesa and LLVM leave threads and exit handlers behind that would point into unmapped code.
SharedLibrary::~SharedLibrary() = default;

void* SharedLibrary::address(const char* symbol) const {
    void* found = dlsym(handle_, symbol);
    if (!found)
        throw scenes::FileError(file_,
                                "has no function " + std::string(symbol) + ", expected Mesa's library");
    return found;
}

}  // namespace atropos::render
