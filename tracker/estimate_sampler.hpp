#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "scenes/thread_estimate.hpp"
#include "tracker/bspline_basis.hpp"

namespace atropos::tracker {

/// Turns control points into the samples of a ThreadEstimate: 101 at equal steps of arc length. Allocates
/// only the first time.
class EstimateSampler {
  public:
    static constexpr int kSamples = 101;

    EstimateSampler(int degree, int control_points);

    /// Overwrites positions and arc lengths of `samples`; sigmas become 0.
    void sample(std::span<const Eigen::Vector3d> control_points, std::vector<scenes::ThreadSample>& samples);

  private:
    BasisTable table_;
    std::vector<Eigen::Vector3d> dense_;
    std::vector<double> arc_m_;
};

}  // namespace atropos::tracker
