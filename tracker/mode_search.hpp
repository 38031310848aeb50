#pragma once

#include <array>
#include <vector>

#include "scenes/worker_pool.hpp"
#include "tracker/curve_sampling.hpp"
#include "tracker/deformation_prior.hpp"
#include "tracker/eye.hpp"
#include "tracker/stereo_cost_images.hpp"

namespace atropos::tracker {

/// A search over whole curves before the one over single control points: labels are joint moves of all of
/// them along the first learned modes (the paper's "deformation priors").
class ModeSearch {
  public:
    ModeSearch(const scenes::TrackerConfig& config, const scenes::StereoRig& rig, int control_points);

    /// `Q` (3 x K, in C, m) moved to the least energy (eq. 4) among all combinations of labels along the
    /// first three modes, then along each further one. `length_m`: of C'_ref.
    Eigen::Matrix3Xd nearest(const StereoFrame& frame, const Eigen::Matrix3Xd& Q, double length_m,
                             const DeformationModes& modes, scenes::WorkerPool& pool);

  private:
    scenes::TrackerConfig config_;
    scenes::StereoRig rig_;
    std::array<Eye, 2> eyes_;
    CurveSampling sampling_;
    std::vector<double> speed_m_;
    std::vector<Eigen::Vector3d> points_;
};

}  // namespace atropos::tracker
