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
    /// `method` kE1 or kE2; `labels` says r, shape and depth factor. `labels_per_node`: of the set L(r, s),
    /// or of another that the owner places.
    DiscreteSearch(scenes::TrackerMethod method, scenes::LabelOptimiser optimiser,
                   const scenes::TrackerConfig::Labels& labels, int control_points, int labels_per_node);
    DiscreteSearch(scenes::TrackerMethod method, scenes::LabelOptimiser optimiser,
                   const scenes::TrackerConfig::Labels& labels, int control_points)
        : DiscreteSearch(method, optimiser, labels, control_points, 14 * labels.r + 1) {}

    /// Lays labels of spacing `s_m` around every control point.
    void place_labels(std::span<const Eigen::Vector3d> control_points, double s_m,
                      const std::array<Eye, 2>& eyes);

    /// Pixels of an eye that any labelling of the placed labels can move sample j to: a sample moves by a
    /// convex combination of the labels of its nodes, and a projection keeps convex hulls.
    cv::Rect reach(const EnergyContext& context, std::size_t eye,
                   std::span<const Eigen::Vector3d> control_points, int j) const;

    /// Moves `control_points` by the placed labels that minimise the approximate energy; `labelling` gets the
    /// label of each node. Adds the time spent to `timings`. Returns the approximate energy reached.
    double minimise(const EnergyContext& context, scenes::WorkerPool& pool,
                    std::vector<Eigen::Vector3d>& control_points, std::span<int> labelling,
                    StageTimings& timings);

    /// Of the last step.
    const NodeLabels& labels() const { return node_labels_; }
    NodeLabels& labels() { return node_labels_; }
    const ChainProblem& chain() const { return chain_; }

  private:
    scenes::TrackerConfig::Labels options_;
    NodeLabels node_labels_;
    ChainProblem chain_;
    std::unique_ptr<Potentials> potentials_;
    std::unique_ptr<ChainOptimiser> optimiser_;
    std::vector<Eigen::Vector3d> unit_labels_;  ///< s = 1 along the axes of C
    std::vector<Eigen::Vector3d> scaled_;
    bool same_at_every_node_ = false;
    std::vector<int> outermost_;  ///< the labels at the end of each direction: corners of the set's hull
};

/// Shows the curve and each node after step `step`, with the min-marginal cost of the label chosen.
void show_step(TrackObserver& observer, int step, const DiscreteSearch& search,
               std::span<const int> labelling, std::span<const Eigen::Vector3d> control_points);

}  // namespace atropos::tracker
