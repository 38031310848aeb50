#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "tests/bench/finder_cases.hpp"

namespace atropos::bench {

/// One stereo frame of which no end is measured, and what there is to be found in it.
struct FinderFrame {
    scenes::StereoRig rig;
    scenes::TrackerConfig config = {};  ///< polarity and channel
    tracker::StereoFrame frame;
    scenes::Polyline visible_C;
    std::array<ImageLine, 2> visible_px = {};
};

/// A kind of frame: one for each seed, or nothing where the seed gives none of that kind.
struct FinderCase {
    const char* name;
    std::function<std::optional<FinderFrame>(std::uint64_t seed)> draw;
};

/// A row for each case: how often the finder is right, and whether it knows.
void print_cases(const FinderTableOptions& options, const std::vector<FinderCase>& cases);

/// Whether all of a line lies in the image of both eyes and crosses itself in both so often.
bool is_whole(const std::array<ImageLine, 2>& line_px, const scenes::StereoRig& rig, int crossings);

}  // namespace atropos::bench
