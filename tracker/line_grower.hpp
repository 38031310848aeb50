#pragma once

#include <array>

#include "scenes/tracker_config.hpp"
#include "tracker/line_course.hpp"
#include "tracker/strand_search.hpp"

namespace atropos::tracker {

struct LineGrowerOptions {
    LineCourseOptions course;
    double step_px = 1.5;
    double search_px = 2.5;        ///< about where a line that goes on as it came is seen next
    double least_contrast = 0.3;   ///< of the line's contrast behind: still the line
    double least_clutter = 1.3;    ///< of what lies beside it: a line at all
    double longest_gap_px = 30.0;  ///< without sight of it, as over a fold of the ground
    double sure_share = 0.6;       ///< of the line's contrast: a stretch that is the line beyond a longer gap
};

/// Why a line ends where it does.
enum class LineEnd {
    kPlain,   ///< both eyes see no more of it
    kHidden,  ///< an instrument hides what comes
    kLeaves,  ///< the image ends
    kOneEye,  ///< one eye sees it go on
    kItself,  ///< it runs on along itself
    kFades,   ///< somewhere here, its contrast is lost little by little
};

/// Follows a line in both eyes at once, from its surest stretch to where it ends in both: as long as it goes
/// on in space as it came, with the contrast it had. Texture and vessels may lead one eye astray, but not
/// both to the same place. What the paths have beyond a longer gap is taken where it is the line as surely.
/// Returns why it ends, in the left path's order. `turned`: the right path runs the other way;
/// `row_offset_px`: rows of the right eye lie lower by it.
std::array<LineEnd, 2> grow_line(const RectifiedView& view, const std::array<EyeLines, 2>& eyes,
                                 scenes::ThreadPolarity polarity, bool turned, double row_offset_px,
                                 std::array<ImagePath, 2>& paths, const LineGrowerOptions& options = {});

}  // namespace atropos::tracker
