#include "tests/support/scalar_energy.hpp"

#include <cmath>
#include <functional>
#include <vector>

namespace atropos::support {
namespace {

using tracker::EnergyContext;

double weighted_sum(const EnergyContext& context, std::span<const Eigen::Vector3d> moved,
                    const std::function<double(int)>& alpha) {
    double sum = 0.0;
    for (int j = 0; j < context.sampling.samples(); ++j) {
        const double weight = alpha(j) * context.sampling.du();
        if (weight == 0.0) continue;
        const Eigen::Vector3d p_C = context.sampling.point(moved, j);
        for (std::size_t eye = 0; eye < 2; ++eye) {
            const Eigen::Vector2d px = context.eyes[eye].pixel(context.eyes[eye].homogeneous(p_C));
            sum += 0.5 * weight * context.weights.px_scale *
                   context.costs[eye]->at(static_cast<float>(px.x()), static_cast<float>(px.y()));
        }
        const double speed = context.sampling.velocity(moved, j).norm();
        sum += context.weights.length * weight *
               std::pow(1.0 - speed / context.reference_speed_m[static_cast<std::size_t>(j)], 2);
    }
    return sum;
}

}  // namespace

double scalar_V1ab(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
                   const Eigen::Vector3d& l_p, int p) {
    std::vector<Eigen::Vector3d> moved(control_points.begin(), control_points.end());
    moved[static_cast<std::size_t>(p)] += l_p;
    return weighted_sum(context, moved, [&](int j) { return context.sampling.R(p, j); });
}

double scalar_V2ab(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
                   const Eigen::Vector3d& l_p, const Eigen::Vector3d& l_q, int p) {
    std::vector<Eigen::Vector3d> moved(control_points.begin(), control_points.end());
    moved[static_cast<std::size_t>(p)] += l_p;
    moved[static_cast<std::size_t>(p + 1)] += l_q;
    return weighted_sum(context, moved, [&](int j) {
        double all = 0.0;
        for (int k = 0; k + 1 < context.sampling.control_points(); ++k)
            all += context.sampling.R(k, j) * context.sampling.R(k + 1, j);
        return context.sampling.R(p, j) * context.sampling.R(p + 1, j) / all;
    });
}

void ScalarPotentialsE1::fill(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
                              const tracker::NodeLabels& labels, scenes::WorkerPool&,
                              tracker::ChainProblem& chain) {
    chain.clear();
    for (int p = 0; p < chain.nodes(); ++p)
        for (int l = 0; l < labels.labels(); ++l) {
            chain.unary(p)[static_cast<std::size_t>(l)] =
                static_cast<float>(scalar_V1ab(context, control_points, labels.displacement(p, l), p));
            for (int m = 0; p + 1 < chain.nodes() && m < labels.labels(); ++m)
                chain.pairwise(p)[static_cast<std::size_t>(l * chain.stride() + m)] =
                    static_cast<float>(context.weights.smooth_per_m *
                                       (labels.displacement(p, l) - labels.displacement(p + 1, m)).norm());
        }
    tracker::add_node_costs(context, control_points, labels, chain);
}

void ScalarPotentialsE2::fill(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
                              const tracker::NodeLabels& labels, scenes::WorkerPool&,
                              tracker::ChainProblem& chain) {
    chain.clear();
    for (int p = 0; p + 1 < chain.nodes(); ++p)
        for (int l = 0; l < labels.labels(); ++l)
            for (int m = 0; m < labels.labels(); ++m)
                chain.pairwise(p)[static_cast<std::size_t>(l * chain.stride() + m)] =
                    static_cast<float>(scalar_V2ab(context, control_points, labels.displacement(p, l),
                                                   labels.displacement(p + 1, m), p));
    tracker::add_node_costs(context, control_points, labels, chain);
}

}  // namespace atropos::support
