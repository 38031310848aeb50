#include "tracker/discrete_search.hpp"

#include <chrono>
#include <cmath>
#include <string>

#include "tracker/label_set.hpp"

namespace atropos::tracker {
namespace {

double ms_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

DiscreteSearch::DiscreteSearch(scenes::TrackerMethod method, scenes::LabelOptimiser optimiser,
                               const scenes::TrackerConfig::Labels& labels, int control_points)
    : options_(labels),
      node_labels_(control_points, 14 * labels.r + 1),
      chain_(control_points, 14 * labels.r + 1),
      optimiser_(make_chain_optimiser(optimiser)),
      unit_labels_(label_set(labels.r, 1.0)),
      scaled_(unit_labels_.size()) {
    if (method == scenes::TrackerMethod::kE1)
        potentials_ = std::make_unique<PotentialsE1>();
    else
        potentials_ = std::make_unique<PotentialsE2>();
}

double DiscreteSearch::step(const EnergyContext& context, double s_m, WorkerPool& pool,
                            std::vector<Eigen::Vector3d>& control_points, std::span<int> labelling,
                            StageTimings& timings) {
    const auto begin = std::chrono::steady_clock::now();
    for (std::size_t k = 0; k < control_points.size(); ++k) {
        const Eigen::Matrix3d axes = options_.shape == scenes::LabelShape::kRays
                                         ? ray_axes(control_points[k], options_.depth_factor)
                                         : Eigen::Matrix3d::Identity();
        for (std::size_t l = 0; l < scaled_.size(); ++l) scaled_[l] = axes * (s_m * unit_labels_[l]);
        node_labels_.set(static_cast<int>(k), scaled_, context.eyes);
    }
    potentials_->fill(context, control_points, node_labels_, pool, chain_);
    timings.potentials_ms += ms_since(begin);

    const auto filled = std::chrono::steady_clock::now();
    const double cost = optimiser_->minimise(chain_, labelling);
    for (std::size_t k = 0; k < control_points.size(); ++k)
        control_points[k] += node_labels_.displacement(static_cast<int>(k), labelling[k]);
    timings.optimiser_ms += ms_since(filled);
    return cost;
}

double DiscreteSearch::reach_m(double s_m) const {
    const double depth = options_.shape == scenes::LabelShape::kRays ? options_.depth_factor : 1.0;
    return options_.r * s_m * std::sqrt(2.0 + depth * depth);
}

void show_step(TrackObserver& observer, int step, const DiscreteSearch& search,
               std::span<const int> labelling, std::span<const Eigen::Vector3d> control_points) {
    observer.curve("step " + std::to_string(step), control_points);
    ChainDp exact;
    const std::span<const float> marginals = exact.min_marginals(search.chain());
    for (std::size_t k = 0; k < labelling.size(); ++k) {
        const std::size_t label = static_cast<std::size_t>(labelling[k]);
        observer.node(
            step, static_cast<int>(k), labelling[k],
            search.labels().displacement(static_cast<int>(k), labelling[k]),
            static_cast<double>(marginals[k * static_cast<std::size_t>(search.chain().stride()) + label]));
    }
}

}  // namespace atropos::tracker
