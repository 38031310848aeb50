#pragma once

#include <array>
#include <optional>
#include <vector>

#include "tracker/ground_depth.hpp"
#include "tracker/image_path.hpp"
#include "tracker/path_joiner.hpp"
#include "tracker/strand.hpp"
#include "tracker/strand_mender.hpp"

namespace atropos::tracker {

struct StrandSearchOptions {
    PathJoinerOptions joiner;
    StrandOptions strand;
    StrandMenderOptions mender;
    int candidates = 10;           ///< strongest paths of each eye that are paired with each other
    double seed_reach_px = 12.0;   ///< from a given point to the thread
    double rival_share = 0.3;      ///< of the strongest line's strength: vies with it
    double standing_px = 1.5;      ///< disparity before the ground from which a line stands off it
    double lying_weight = 0.3;     ///< of a line on the ground beside one that stands off
    double companion_share = 0.7;  ///< standing, from which a line may belong to the chosen one
    int attempts = 6;              ///< at joining the pieces
};

/// What one eye sees.
struct EyeLines {
    cv::Mat buffer;
    ImageView image;
    RidgePointMap map;
    std::vector<ImagePath> pieces;
};

/// The line that is taken for the thread.
struct ChosenStrand {
    Strand strand;
    std::array<ImagePath, 2> path;
    double weight = 0.0;  ///< strength of what stands off the ground
    double rival = 0.0;   ///< share of that which another line has that has nothing in common with it
    std::optional<DepthLeap> leap;   ///< where it nevertheless runs on into another line
    std::vector<Strand> companions;  ///< others that stand off the ground
};

/// Joins both eyes' pieces to the line that most looks like a thread: strong in both eyes and, where lines
/// vie, standing off the ground. What one eye joins wrongly, the other and the depth mend.
class StrandSearch {
  public:
    StrandSearch(const scenes::StereoRig& rig, const StrandSearchOptions& options)
        : options_(options), view_(rig), ground_(rig) {}

    /// `eyes`: pieces are cut where they go astray. Nothing where no line is seen by both eyes.
    std::optional<ChosenStrand> search(std::array<EyeLines, 2>& eyes,
                                       const std::optional<Eigen::Vector2d>& seed_px);

    /// Where a line of this frame leaps in depth; `turned`: its right path runs the other way.
    std::optional<DepthLeap> leap(const std::array<ImagePath, 2>& path, bool turned) const;

  private:
    StereoPaths joined(const std::array<EyeLines, 2>& eyes,
                       const std::optional<Eigen::Vector2d>& seed_px) const;
    std::optional<ChosenStrand> choose(const std::array<EyeLines, 2>& eyes, const StereoPaths& paths);
    bool learn(const StereoWishes& wishes, std::array<EyeLines, 2>& eyes);

    StrandSearchOptions options_;
    RectifiedView view_;
    GroundDepth ground_;
    StereoWishes wishes_;
};

}  // namespace atropos::tracker
