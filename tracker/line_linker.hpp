#pragma once

#include <vector>

#include "tracker/image_path.hpp"
#include "tracker/ridge_points.hpp"

namespace atropos::tracker {

struct LineLinkerOptions {
    double high_levels = 6.0;  ///< strength that a piece must reach somewhere
    int least_points = 5;      ///< of a piece that is worth having
};

/// Links ridge points to pieces of lines, the strongest first, and cuts the pieces where they turn sharply
/// and where others meet them: what goes on where is not decided here.
std::vector<ImagePath> link_lines(const RidgePointMap& map, const LineLinkerOptions& options);

}  // namespace atropos::tracker
