#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "experiments/sequence.hpp"
#include "scenes/tracker_config.hpp"

namespace atropos::experiments {

/// The Bayesian Cramer-Rao bound of a sequence's curves (tracker/cramer_rao_bound.hpp), of every tenth frame
/// with a span: contrast and noise as its pictures have them along the true curve, priors as `config` states
/// them.
struct SequenceBound {
    std::vector<double> mean_3d_mm;  ///< of each of those frames
    nlohmann::ordered_json assumed;  ///< by name: what the images hold, and the priors
};

/// Throws scenes::FileError when no picture shows the thread.
SequenceBound sequence_bound(const Sequence& sequence, const std::vector<TruthFrame>& truth,
                             const scenes::TrackerConfig& config);

}  // namespace atropos::experiments
