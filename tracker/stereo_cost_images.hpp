#pragma once

#include <array>
#include <vector>

#include "scenes/worker_pool.hpp"
#include "tracker/cost_image.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::tracker {

/// The cost images of both eyes, over the whole images or where they are wanted.
class StereoCostImages {
  public:
    /// `sigmas_px`: scales of the detector; `truncation_px` of the distance in pixels of these images.
    StereoCostImages(const scenes::TrackerConfig& config, std::vector<double> sigmas_px, int truncation_px);

    /// A new frame, of which nothing is known until it is asked for (CostImageMaker).
    void begin(const StereoFrame& frame);
    void set_truncation(int truncation_px);
    void want(int eye, const cv::Rect& region) { makers_[static_cast<std::size_t>(eye)].want(region); }
    void compute(scenes::WorkerPool& pool);

    /// The whole of both images of a new frame.
    void make(const StereoFrame& frame, scenes::WorkerPool& pool);

    std::array<const CostImage*, 2> costs() const { return {&makers_[0].cost(), &makers_[1].cost()}; }

    /// Shows gray, ridge, mask and cost of both eyes.
    void show(TrackObserver& observer) const;

  private:
    std::array<CostImageMaker, 2> makers_;
};

}  // namespace atropos::tracker
