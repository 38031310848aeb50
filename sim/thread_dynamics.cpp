#include "sim/thread_dynamics.hpp"

#include <stdexcept>

namespace atropos::sim {

void ThreadDynamics::cut(int edge, double t) {
    if (!state_.has_edge(edge) || !(t >= 0.0 && t <= 1.0))
        throw std::invalid_argument(
            "ThreadDynamics::cut: no edge there, expected an existing edge and t in [0, 1]");
    const auto i = static_cast<size_t>(edge);
    const auto insert = [](auto& list, size_t at, auto value) {
        list.insert(list.begin() + static_cast<std::ptrdiff_t>(at), std::move(value));
    };
    if (t == 0.0 || t == 1.0) {  // on a node: double it, a zero-length edge would have no direction
        const size_t node = t == 0.0 ? i : i + 1;
        insert(state_.p_W, node, Eigen::Vector3d(state_.p_W[node]));
        insert(state_.v_W, node, Eigen::Vector3d(state_.v_W[node]));
        insert(state_.s_m, node, double(state_.s_m[node]));
        insert(state_.joined, node, char{0});
        return;
    }
    const Eigen::Vector3d p = (1.0 - t) * state_.p_W[i] + t * state_.p_W[i + 1];
    const Eigen::Vector3d v = (1.0 - t) * state_.v_W[i] + t * state_.v_W[i + 1];
    const double s = state_.s_m[i] + t * state_.rest_length_m(edge);
    for (int copy = 0; copy < 2; ++copy) {
        insert(state_.p_W, i + 1, p);
        insert(state_.v_W, i + 1, v);
        insert(state_.s_m, i + 1, s);
    }
    insert(state_.joined, i + 1, char{0});
    insert(state_.joined, i + 2, char{1});
}

ThreadState state_along(const std::vector<Eigen::Vector3d>& points) {
    if (points.size() < 3) throw std::invalid_argument("state_along: a thread needs at least 3 points");
    ThreadState state;
    state.p_W = points;
    state.v_W.assign(points.size(), Eigen::Vector3d::Zero());
    state.s_m.assign(points.size(), 0.0);
    for (size_t i = 1; i < points.size(); ++i)
        state.s_m[i] = state.s_m[i - 1] + (points[i] - points[i - 1]).norm();
    state.joined.assign(points.size() - 1, char{1});
    return state;
}

}  // namespace atropos::sim
