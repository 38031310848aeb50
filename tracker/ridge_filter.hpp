#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "scenes/tracker_config.hpp"

namespace atropos::tracker {

struct RidgeFilterOptions {
    std::vector<double> sigmas_px;  ///< scales of the Hessian
    double blobness = 0.5;          ///< Frangi's beta
    double contrast_levels = 8.0;   ///< Frangi's c, grey levels
    scenes::ThreadPolarity polarity = scenes::ThreadPolarity::kDark;
    double floor = 0.0;  ///< values up to it may be given as 0: most pixels, at a fraction of the time
};

/// Multi-scale detector of curvilinear structures from the Hessian of the smoothed image (II-E; Frangi,
/// Niessen, Vincken and Viergever, "Multiscale vessel enhancement filtering", MICCAI 1998, eq. 15 in 2D):
/// with the eigenvalues |l1| <= |l2| of sigma^2 times the Hessian, R = l1 / l2 and S^2 = l1^2 + l2^2,
///   v = exp(-R^2 / 2 beta^2) (1 - exp(-S^2 / 2 c^2)), 0 where l2 has the wrong sign; the maximum over sigma.
/// The Hessian is the second difference of the image smoothed by a Gaussian; beyond the border the image is
/// continued by its last pixels.
class RidgeFilter {
  public:
    explicit RidgeFilter(RidgeFilterOptions options);

    const RidgeFilterOptions& options() const { return options_; }

    /// Makes room for regions of this size, so that smaller ones allocate nothing.
    void reserve(int width, int height);

    /// Pixels around a region that its result depends on.
    int reach_px() const { return reach_px_; }

    /// `gray`: float image of which `region` is wanted (inside the image). `ridge`: region.width x
    /// region.height values in [0, 1], dense. The bytes inside don't depend on how large the region is.
    void apply(const float* gray, int width, int height, std::size_t stride, const cv::Rect& region,
               std::vector<float>& ridge);

  private:
    void accumulate_scale(double sigma_px, int region_width, int region_height, std::vector<float>& ridge);

    RidgeFilterOptions options_;
    int reach_px_ = 0;
    int source_width_ = 0;
    std::vector<float> source_;      ///< region grown by reach, border repeated
    std::vector<float> horizontal_;  ///< after the row pass
    std::vector<float> smooth_;      ///< after both, region grown by 1
};

/// The scales that `config` asks for on images with `px_per_m` pixels a metre at the thread.
std::vector<double> ridge_scales_px(const scenes::TrackerConfig& config, double px_per_m);

}  // namespace atropos::tracker
