#pragma once

#include <string>

namespace atropos::render {

/// Walks a PLY file by its own header: every element is there, every face names vertices that are there.
/// assimp believes such files, and hangs, aborts or reads past the end where they lie. Throws
/// scenes::FileError.
void check_ply(const std::string& file);

}  // namespace atropos::render
