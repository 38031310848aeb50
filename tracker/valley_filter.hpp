#pragma once

#include <array>

#include "scenes/tracker_config.hpp"
#include "tracker/normal_profile.hpp"

namespace atropos::tracker {

/// A dark (or bright) line crossed by a normal line, lower than both of its sides.
struct Valley {
    double offset_px = 0.0;   ///< along the normal, from p_px
    double depth_levels = 0;  ///< grey levels to the nearer of both sides
};

struct ValleyFilterOptions {
    scenes::ThreadPolarity polarity = scenes::ThreadPolarity::kDark;
    double threshold_levels = 4.0;  ///< depth below which a valley is noise
    double blur_px = 0.65;          ///< standard deviation of the optics and the pixel
    int taps = 5;                   ///< profiles averaged along the tangent
    double tap_step_px = 1.0;
};

/// Looks for thin lines along normals, on 8-bit images without any filtering of the whole frame. A valley
/// must be two-sided: a step, such as the rim of an instrument, is none.
class ValleyFilter {
  public:
    static constexpr int kMaxValleys = 4;

    explicit ValleyFilter(const ValleyFilterOptions& options) : options_(options) {}

    const ValleyFilterOptions& options() const { return options_; }

    /// Up to kMaxValleys deepest valleys within `search_px` of the line's point, written to `valleys`;
    /// `width_px` is the thread's expected width. Returns their number; 0 also where the image ends.
    /// `threshold_share` of the options' threshold applies.
    int find(const ImageView& image, const NormalLine& line, double search_px, double width_px,
             std::array<Valley, kMaxValleys>& valleys, double threshold_share = 1.0) const;

    /// Least-squares position of a blurred bar on a sloped ground.
    struct Localisation {
        double offset_px = 0.0;
        double contrast_levels = 0.0;  ///< of the bar before blur
        double noise_levels = 0.0;     ///< rms of what the model leaves over
        double sigma_px_per_noise_level = 0.0;
        double contrast_sigma_levels = 0.0;
    };

    /// Bar and slope fitted around the line's point, one Gauss-Newton step: the most that the pixels can tell
    /// of the offset (Cramer-Rao). False where the image ends or no bar of this polarity is there.
    bool localise(const ImageView& image, const NormalLine& line, double width_px, Localisation& found) const;

  private:
    ValleyFilterOptions options_;
};

}  // namespace atropos::tracker
