#pragma once

#include <cstddef>
#include <span>

#include "tracker/line_course.hpp"

namespace atropos::tracker {

/// How many nodes at the back of a line have, taken together, less than a share of the contrast that the
/// 30 px before them have: what is most below it less what is above.
std::ptrdiff_t fainter_at_back(std::span<const LineNode> line, double share);

}  // namespace atropos::tracker
