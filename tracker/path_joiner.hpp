#pragma once

#include <optional>
#include <vector>

#include "tracker/image_path.hpp"
#include "tracker/ridge_points.hpp"

namespace atropos::tracker {

struct PathJoinerOptions {
    double reach_px = 32.0;     ///< longest gap that is bridged, as by a highlight
    double gap_px = 12.0;       ///< gap, and
    double bend_rad = 0.45;     ///< bend at either side of it, that cost 1 when joining
    double dearest_join = 4.0;  ///< cost beyond which ends stay apart
};

/// What is known of some joins from elsewhere.
struct JoinWishes {
    std::vector<PathJoin> forbidden, wanted;  ///< either way around
    std::vector<Eigen::Vector2d> cuts;        ///< places where a piece itself goes astray
};

/// Cuts the piece that runs through a place, some points before and behind it lost; the two ends that this
/// makes. Nothing where there is no piece or too little of it.
std::optional<PathJoin> cut_piece(std::vector<ImagePath>& pieces, const Eigen::Vector2d& px);

/// Joins ends of pieces to paths, the wanted and the cheapest joins first, none that is forbidden: so a path
/// runs straight through a crossing and over a gap, but not across what hides it. Strongest path first.
std::vector<ImagePath> join_pieces(const std::vector<ImagePath>& pieces, const RidgePointMap& map,
                                   const PathJoinerOptions& options, const JoinWishes& wishes = {});

}  // namespace atropos::tracker
