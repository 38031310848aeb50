#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "scenes/tracker_config.hpp"
#include "tracker/image_view.hpp"

namespace atropos::tracker {

/// A point on the centre line of a thin line, to a fraction of a pixel.
struct RidgePoint {
    Eigen::Vector2d px = Eigen::Vector2d::Zero();
    Eigen::Vector2d tangent = Eigen::Vector2d::UnitX();  ///< unit; either way until traced
    double strength_levels = 0.0;                        ///< sigma^2 |second derivative across the line|
};

/// Ridge points of an image and where they are: at most one a pixel.
struct RidgePointMap {
    static constexpr std::int32_t kNone = -1;
    static constexpr std::int32_t kHidden = -2;  ///< something lies before it: no line is bridged across

    int width = 0;
    int height = 0;
    std::vector<RidgePoint> points;  ///< in scan order
    std::vector<std::int32_t>
        at_pixel;  ///< index of the point in this pixel, kNone or kHidden; width * height

    int index(int u, int v) const {
        if (u < 0 || v < 0 || u >= width || v >= height) return kNone;
        return at_pixel[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                        static_cast<std::size_t>(u)];
    }
};

struct RidgePointOptions {
    double sigma_px = 1.4;       ///< of the Gaussian; lines up to 3.5 times as wide have one ridge
    double low_levels = 2.5;     ///< strength below which there is no point
    double gloss_levels = 30.0;  ///< above the ground around: a spot of gloss, levelled where lines are dark
    scenes::ThreadPolarity polarity = scenes::ThreadPolarity::kDark;
};

/// Where the image, smoothed by a Gaussian, is extremal across the direction of its strongest curvature
/// (Steger, "An unbiased detector of curvilinear structures", PAMI 1998, section 3.2). A step edge has no
/// such point. The outermost pixels have none.
class RidgePointDetector {
  public:
    explicit RidgePointDetector(const RidgePointOptions& options) : options_(options) {}

    void detect(const ImageView& image, RidgePointMap& map);

  private:
    void level_gloss();

    RidgePointOptions options_;
    cv::Mat1f source_, smooth_, coarse_, ground_;
    cv::Mat1b coarse_bytes_, ground_bytes_, gloss_;
};

}  // namespace atropos::tracker
