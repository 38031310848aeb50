#pragma once

#include <opencv2/core.hpp>

#include "experiments/endoscope_view.hpp"
#include "scenes/thread_estimate.hpp"

namespace atropos::experiments {

/// The field from the side, as a drawing: true capsules of the arms and true thread, tracked thread over it.
/// For people only.
cv::Mat draw_outside_view(const Testbed& testbed, const std::vector<TruthSample>& samples,
                          const scenes::ThreadEstimate& estimate, cv::Size size);

}  // namespace atropos::experiments
