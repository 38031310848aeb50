#pragma once

#include <vector>

#include "tracker/image_path.hpp"
#include "tracker/image_view.hpp"

namespace atropos::tracker {

/// Both edges of a line, as offsets along the normal (-tangent.y, tangent.x) of a point of its path.
struct LineEdges {
    bool found = false;
    double low_px = 0.0;
    double high_px = 0.0;
    double foot_width_px = 0.0;  ///< at a lower level, where a pale rim still counts; 0 = unknown, as on
                                 ///< uneven ground

    double width_px() const { return high_px - low_px; }
    double middle_px() const { return 0.5 * (low_px + high_px); }
};

/// The outermost crossings, within `reach_px`, of a level between ground and line, taken on each side by
/// itself: a gloss along the line's middle splits neither its width nor its centre.
std::vector<LineEdges> line_edges(const ImageView& image, const ImagePath& path,
                                  scenes::ThreadPolarity polarity, double reach_px = 9.0);

/// Cuts off an end of the path where, on average over 15 px, the line is more than `ratio` times as wide as
/// its median: a needle (its edges are `edges`, one a point). Returns whether something was cut.
bool cut_needles(ImagePath& path, std::vector<LineEdges>& edges, double ratio);

/// Moves the points of a path to the middle between the edges, smoothed over neighbours.
void centre_between_edges(ImagePath& path, const std::vector<LineEdges>& edges);

}  // namespace atropos::tracker
