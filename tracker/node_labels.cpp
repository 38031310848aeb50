#include <stdexcept>
#include <string>

#include "tracker/potentials.hpp"

namespace atropos::tracker {

NodeLabels::NodeLabels(int nodes, int labels)
    : labels_(labels),
      stride_((labels + 7) / 8 * 8),
      values_(offset(nodes, 0), 0.0f),
      exact_(static_cast<std::size_t>(nodes * labels)) {
    if (labels > kMost)
        throw std::invalid_argument(std::to_string(labels) + " labels a node, expected at most " +
                                    std::to_string(kMost));
}

void NodeLabels::set(int node, std::span<const Eigen::Vector3d> displacements,
                     const std::array<Eye, 2>& eyes) {
    for (int l = 0; l < labels_; ++l) {
        const Eigen::Vector3d& d = displacements[static_cast<std::size_t>(l)];
        set(node, l, d, {eyes[0].M() * d, eyes[1].M() * d}, 0.0f);
    }
}

void NodeLabels::set(int node, int label, const Eigen::Vector3d& displacement,
                     const std::array<Eigen::Vector3d, 2>& seen, float cost) {
    exact_[index(node, label)] = {displacement, seen, cost};
    for (int channel = 0; channel < 9; ++channel) {
        const Eigen::Vector3d& from =
            channel < 3 ? displacement : seen[static_cast<std::size_t>(channel / 3 - 1)];
        values_[offset(node, channel) + static_cast<std::size_t>(label)] =
            static_cast<float>(from[channel % 3]);
    }
}

void add_node_costs(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
                    const NodeLabels& labels, ChainProblem& chain) {
    for (int p = 0; p < chain.nodes(); ++p)
        for (int l = 0; l < labels.labels(); ++l)
            chain.unary(p)[static_cast<std::size_t>(l)] += labels.cost(p, l);
    for (std::size_t end = 0; end < 2; ++end) {
        if (!context.tips[end]) continue;
        const int node = end == 0 ? 0 : chain.nodes() - 1;
        const std::span<float> unary = chain.unary(node);
        const bool fixed = context.tips[end]->kind == MeasuredTip::Kind::kFixed;
        for (int l = 0; l < labels.labels(); ++l) {
            const Eigen::Vector3d off = control_points[static_cast<std::size_t>(node)] +
                                        labels.displacement(node, l) - context.tips[end]->p_C;
            const double cost = context.weights.tip_per_m * tip_distance(off, context.weights.tip_epsilon_m);
            unary[static_cast<std::size_t>(l)] =
                fixed && l > 0 ? ChainProblem::kForbidden
                               : unary[static_cast<std::size_t>(l)] + static_cast<float>(cost);
        }
    }
}

}  // namespace atropos::tracker
