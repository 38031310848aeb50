#pragma once

#include <array>
#include <vector>

#include "tracker/image_path.hpp"
#include "tracker/path_joiner.hpp"
#include "tracker/strand.hpp"

namespace atropos::tracker {

/// How the pieces of each eye should be joined otherwise, so that both eyes see one line.
using StereoWishes = std::array<JoinWishes, 2>;

struct StrandMenderOptions {
    double reach_px = 30.0;    ///< from a place that is wrong to the join that is to blame
    double gap_px = 60.0;      ///< longest gap, as the other eye sees it, that is closed
    double leap_px = 3.0;      ///< of disparity, across a gap
    double overlap_px = 15.0;  ///< of two lines that still follow each other
};

/// Where a strand leaps in depth, the join that led it astray is to be taken back.
StereoWishes mend_leap(const RectifiedView& view, const Strand& strand, const DepthLeap& leap,
                       const StereoPaths& paths, const StrandMenderOptions& options);

/// Where one eye sees as one line what the other has torn, as by gloss or at a crossing with something else,
/// the torn line is to be joined as the one eye sees it. `others`: strands that may go on where this one
/// ends.
StereoWishes mend_tears(const Strand& strand, const std::vector<Strand>& others, const StereoPaths& paths,
                        const StrandMenderOptions& options);

/// Where an eye's line runs on beyond an end that an instrument hides from the other, the join beyond that
/// end is to be taken back.
StereoWishes mend_ends(const Strand& strand, const StereoPaths& paths,
                       const std::array<const RidgePointMap*, 2>& maps, const StrandMenderOptions& options);

}  // namespace atropos::tracker
