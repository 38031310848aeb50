#pragma once

#include <array>

#include "scenes/tracker_config.hpp"
#include "tracker/image_path.hpp"
#include "tracker/normal_profile.hpp"

namespace atropos::tracker {

/// Where a line is across a place, and how much darker (brighter) than the nearer ground beside it: a share
/// of the ground's level, so that it means the same in the shade.
struct LineSight {
    double offset_px = 0.0;  ///< along the normal (-tangent.y, tangent.x)
    double contrast = 0.0;   ///< 0: there is none
};

/// Looks for a line of a width in profiles across it, averaged along it: a braid's pattern is finer.
class LineLook {
  public:
    LineLook() = default;
    /// Takes the width from the mean profile of a line.
    LineLook(const ImageView& image, const ImagePath& path, scenes::ThreadPolarity polarity);

    /// The deepest valley within `search_px` of `at`, near ones first.
    LineSight at(const RidgePoint& at, double search_px) const;

    /// What passes for a line on the ground on both sides of `at`: mean contrast.
    double beside(const RidgePoint& at, double search_px) const;

    /// Levels of the ground on both sides of `at`, out to 4 px from a line there.
    std::array<double, 2> sides(const RidgePoint& at) const;

    double width_px() const { return 2.0 * kStep_px * half_width_; }

  private:
    static constexpr double kStep_px = 0.5;

    ImageView image_;
    bool bright_ = false;
    int half_width_ = 2;  ///< at half the depth, steps
};

}  // namespace atropos::tracker
