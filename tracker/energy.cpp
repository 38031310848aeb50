#include "tracker/energy.hpp"

#include <algorithm>
#include <cmath>

namespace atropos::tracker {
namespace {

double cost_px(const EnergyContext& context, std::size_t eye, const Eigen::Vector3d& seen) {
    const Eigen::Vector2d pixel = context.eyes[eye].pixel(seen);
    return context.weights.px_scale *
           context.costs[eye]->at(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
}

}  // namespace

double tip_distance(const Eigen::Vector3d& x, double epsilon) {
    const double norm = x.norm();
    return norm <= epsilon ? 0.0 : norm;
}

EnergyTerms energy(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points) {
    const CurveSampling& sampling = context.sampling;
    EnergyTerms terms;
    for (int j = 0; j < sampling.samples(); ++j) {
        for (std::size_t eye = 0; eye < 2; ++eye)  // eq. 5, 6
            terms.data += 0.5 * sampling.du() * cost_px(context, eye, context.seen(eye, control_points, j));
        const double speed = sampling.velocity(control_points, j).norm();
        const double stretch = 1.0 - speed / context.reference_speed_m[static_cast<std::size_t>(j)];
        terms.length += sampling.du() * stretch * stretch;  // eq. 7
    }
    const std::array<Eigen::Vector3d, 2> ends = {control_points.front(), control_points.back()};
    for (std::size_t end = 0; end < 2; ++end)
        if (context.tips[end])  // eq. 19
            terms.tips += context.weights.tip_per_m *
                          tip_distance(ends[end] - context.tips[end]->p_C, context.weights.tip_epsilon_m);
    terms.total = terms.data + context.weights.length * terms.length + terms.tips;  // eq. 4
    return terms;
}

double support(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
               double within_px) {
    int seen = 0;
    for (int j = 0; j < context.sampling.samples(); ++j)
        for (std::size_t eye = 0; eye < 2; ++eye)
            seen += cost_px(context, eye, context.seen(eye, control_points, j)) <= within_px ? 1 : 0;
    return seen / (2.0 * context.sampling.samples());
}

}  // namespace atropos::tracker
