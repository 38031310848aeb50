#pragma once

#include <array>

#include "tracker/strand_search.hpp"

namespace atropos::tracker {

struct EndCheckOptions {
    double hidden_px = 6.0;       ///< from what hides the rest of a line
    double ahead_px = 45.0;       ///< beyond an end, and
    double aside_rad = 0.6;       ///< to the side, where another line may be the rest of this one
    double bend_rad = 0.6;        ///< and of its direction to the way there
    double steepest = 1.5;        ///< slope to the image plane of the way there, as of a thread
    double strength_share = 0.4;  ///< of the line's own strength: worth being its rest
    double near_px = 15.0;        ///< from the end, any way,
    double alike_share = 0.7;     ///< what is so strong: a sharp turn of it
    double tail_px = 15.0;        ///< of an end that one eye alone sees
};

/// Whether it is known why each end of a line (in the left path's order) is one: an instrument hides what
/// comes, or the image ends, or both eyes see it end there and nothing that could be its rest.
std::array<bool, 2> ends_are_plain(const RectifiedView& view, const std::array<ImagePath, 2>& path,
                                   bool turned, const std::array<EyeLines, 2>& eyes,
                                   const EndCheckOptions& options);

}  // namespace atropos::tracker
