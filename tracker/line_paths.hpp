#pragma once

#include <array>
#include <span>

#include "tracker/line_grower.hpp"

namespace atropos::tracker {

/// Both eyes' paths anew, as a line that was followed has them: their own points between nodes that came from
/// them, the nodes elsewhere. Where the line leaves one eye's image, the other eye's path goes on as it did.
void write_paths(std::span<const LineNode> line, const std::array<LineEnd, 2>& ends,
                 const std::array<EyeLines, 2>& eyes, std::array<ImagePath, 2>& paths);

}  // namespace atropos::tracker
