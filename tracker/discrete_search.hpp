#pragma once

#include <memory>
#include <span>
#include <vector>

#include "tracker/chain_dp.hpp"
#include "tracker/potentials.hpp"

namespace atropos::tracker {

/// One optimisation step of II-D: labels around the curve, potentials of E1 or E2, minimum on the chain,
/// move.
class DiscreteSearch {
  public:
    /// `method` kE1 or kE2; `labels` says r, shape and depth factor.
    DiscreteSearch(scenes::TrackerMethod method, scenes::LabelOptimiser optimiser,
                   const scenes::TrackerConfig::Labels& labels, int control_points);

    /// Moves `control_points` by the labels of spacing `s_m` that minimise the approximate energy;
    /// `labelling` gets the label of each node. Adds the time spent to `timings`. Returns the approximate
    /// energy reached.
    double step(const EnergyContext& context, double s_m, WorkerPool& pool,
                std::vector<Eigen::Vector3d>& control_points, std::span<int> labelling,
                StageTimings& timings);

    /// Of the last step.
    const NodeLabels& labels() const { return node_labels_; }
    const ChainProblem& chain() const { return chain_; }

    /// Largest displacement of one step with spacing `s_m`.
    double reach_m(double s_m) const;

  private:
    scenes::TrackerConfig::Labels options_;
    NodeLabels node_labels_;
    ChainProblem chain_;
    std::unique_ptr<Potentials> potentials_;
    std::unique_ptr<ChainOptimiser> optimiser_;
    std::vector<Eigen::Vector3d> unit_labels_;  ///< s = 1 along the axes of C
    std::vector<Eigen::Vector3d> scaled_;
};

/// Shows the curve and each node after step `step`, with the min-marginal cost of the label chosen.
void show_step(TrackObserver& observer, int step, const DiscreteSearch& search,
               std::span<const int> labelling, std::span<const Eigen::Vector3d> control_points);

}  // namespace atropos::tracker
