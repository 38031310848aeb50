#pragma once

#include <string>

namespace atropos::render {

/// A library opened at run time, with its names kept apart from the program's.
class SharedLibrary {
  public:
    /// Throws scenes::FileError naming the library and the Debian package that holds it.
    SharedLibrary(const char* file, const char* package);
    ~SharedLibrary();
    SharedLibrary(const SharedLibrary&) = delete;
    SharedLibrary& operator=(const SharedLibrary&) = delete;

    template <class Function>
    Function* get(const char* symbol) const {
        return reinterpret_cast<Function*>(address(symbol));
    }

  private:
    void* address(const char* symbol) const;

    std::string file_;
    void* handle_;
};

}  // namespace atropos::render
