#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "scenes/worker_pool.hpp"
#include "tracker/discrete_search.hpp"
#include "tracker/stereo_cost_images.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::tracker {

/// Coarse to fine in one frame between its two measured ends: costs are made only where labels can move the
/// curve, ridges detected once. Keeps references to what it is made of.
class StartDescent {
  public:
    /// Of the levels from far-reaching labels and distances to near ones; the fourth leaves the curve within
    /// some pixels.
    static constexpr std::size_t kLevels = 5;

    StartDescent(const scenes::TrackerConfig& config, const scenes::StereoRig& rig, const StereoFrame& frame,
                 std::size_t levels, scenes::WorkerPool& pool);

    struct Found {
        std::vector<Eigen::Vector3d> curve;
        double seen = 0.0;  ///< share of the curve
        double energy = std::numeric_limits<double>::infinity();
    };

    /// From the level `first` down.
    Found run(std::vector<Eigen::Vector3d> curve, std::size_t first);

    /// A slack thread bulges to some side by an amount that its length tells: the sides that are seen best,
    /// at most two. Towards the camera and away from it look alike where the thread runs along the baseline.
    std::vector<std::vector<Eigen::Vector3d>> best_bulges(const std::vector<Eigen::Vector3d>& line);

  private:
    EnergyContext context() const;
    void truncate(double at_640_px);
    void want_along(std::span<const Eigen::Vector3d> curve);

    const scenes::TrackerConfig& config_;
    const scenes::StereoRig& rig_;
    const StereoFrame& frame_;
    scenes::WorkerPool& pool_;
    std::size_t levels_;
    double depth_m_, px_scale_;
    std::array<Eye, 2> eyes_;
    CurveSampling sampling_;
    DiscreteSearch search_;
    StereoCostImages images_;
    std::vector<double> speed_m_;
    std::vector<int> labelling_;
    StageTimings timings_;
};

}  // namespace atropos::tracker
