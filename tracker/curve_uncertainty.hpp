#pragma once

#include <Eigen/Core>
#include <vector>

#include "scenes/thread_estimate.hpp"
#include "tracker/cubic_basis.hpp"

namespace atropos::tracker {

/// Number of samples of an estimate, equal steps of arc length.
constexpr int kEstimateSamples = 101;

/// Samples a cubic curve `Q` (3 x K, in C, m) at equal steps of arc length. Sigmas follow from the covariance
/// of the control points (3K x 3K, point by point): the offset from the curve (not along it), split along and
/// across the viewing ray. `arc` is working memory.
void sample_with_uncertainty(const CubicBasis& basis, const Eigen::Matrix3Xd& Q,
                             const Eigen::MatrixXd& covariance, std::vector<double>& arc,
                             std::vector<scenes::ThreadSample>& samples);

}  // namespace atropos::tracker
