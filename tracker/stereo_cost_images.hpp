#pragma once

#include <array>
#include <span>
#include <vector>

#include "tracker/cost_image.hpp"
#include "tracker/eye.hpp"
#include "tracker/stereo_tracker.hpp"
#include "tracker/worker_pool.hpp"

namespace atropos::tracker {

/// The cost images of both eyes, over the whole images or around a curve.
class StereoCostImages {
  public:
    /// `sigmas_px`: scales of the detector; `truncation_px` of the distance in pixels of these images.
    StereoCostImages(const scenes::TrackerConfig& config, std::vector<double> sigmas_px, int truncation_px);

    void make(const StereoFrame& frame, const std::array<cv::Rect, 2>& regions, WorkerPool& pool);

    std::array<const CostImage*, 2> costs() const { return {&makers_[0].cost(), &makers_[1].cost()}; }

    /// Shows gray, ridge, mask and cost of both eyes.
    void show(TrackObserver& observer) const;

  private:
    std::array<CostImageMaker, 2> makers_;
};

/// Smallest upright rectangle around the images of the points, grown by `margin_px`, clipped to the image.
cv::Rect region_around(const Eye& eye, std::span<const Eigen::Vector3d> points_C, double margin_px,
                       const cv::Size& image);

}  // namespace atropos::tracker
