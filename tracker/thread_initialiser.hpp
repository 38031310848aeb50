#pragma once

#include <optional>
#include <vector>

#include "scenes/worker_pool.hpp"
#include "tracker/start_descent.hpp"

namespace atropos::tracker {

/// Control points of the straight line between two points at even speed.
std::vector<Eigen::Vector3d> straight_line(int degree, int control_points, const Eigen::Vector3d& from,
                                           const Eigen::Vector3d& to);

/// The curve between two measured ends (III): from the straight line by iterations of the same optimisation,
/// from far-reaching labels and distances to near ones. The thread's length is used where `config` gives one;
/// otherwise the curve keeps an even speed of any length. nullopt when an end isn't measured or no thread is
/// seen. `levels`: of five, each finer than the one before; the fourth leaves the curve within some pixels.
std::optional<std::vector<Eigen::Vector3d>> initial_curve_between_tips(
    const scenes::TrackerConfig& config, const scenes::StereoRig& rig, const StereoFrame& frame,
    scenes::WorkerPool& pool, std::size_t levels = StartDescent::kLevels);

}  // namespace atropos::tracker
