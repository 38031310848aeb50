#pragma once

#include <functional>
#include <vector>

#include "sim/rod.hpp"

namespace atropos::sim::testing {

/// Steps until every node is slower than `speed_m_s`, or throws after `limit_s` of simulated time.
inline void come_to_rest(Rod& rod, Boundary& boundary, double speed_m_s = 1e-7, double limit_s = 60.0,
                         double dt_s = 1e-2) {
    std::vector<SurfaceContact> none;
    const RodParameters parameters = rod.parameters();
    rod.parameters().drag_N_s_m2 = 2e-3;  // about critical for the pendulum mode of 70 mm of thread
    rod.parameters().tolerance_m = 1e-11;
    rod.parameters().max_newton = 50;
    rod.parameters().self_contact = false;
    double fastest = 1.0;
    for (double t = 0.0; t < limit_s && fastest > speed_m_s; t += dt_s) {
        rod.step(dt_s, boundary, none);
        fastest = 0.0;
        for (const auto& v : rod.state().v_W) fastest = std::max(fastest, v.norm());
    }
    rod.parameters() = parameters;
    if (fastest > speed_m_s) throw std::runtime_error("rod did not come to rest");
}

inline void run(Rod& rod, Boundary& boundary, double duration_s, double dt_s = 1e-3) {
    std::vector<SurfaceContact> none;
    const int steps = static_cast<int>(duration_s / dt_s + 0.5);
    for (int i = 0; i < steps; ++i) rod.step(dt_s, boundary, none);
}

/// Points at equal steps of `curve` over [0, 1].
inline ThreadState sampled(int edges, const std::function<Eigen::Vector3d(double)>& curve) {
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i <= edges; ++i) points.push_back(curve(double(i) / edges));
    return state_along(points);
}

/// The same nodes with rest lengths that are all equal and sum to `length_m`.
inline ThreadState with_length(ThreadState state, double length_m) {
    for (size_t i = 0; i < state.s_m.size(); ++i)
        state.s_m[i] = length_m * double(i) / double(state.s_m.size() - 1);
    return state;
}

}  // namespace atropos::sim::testing
