#include "sim/rod_memory.hpp"

#include <algorithm>
#include <cmath>

#include "sim/rod_energy.hpp"

namespace atropos::sim {

using Eigen::Vector3d;

namespace {

size_t at(int i) {
    return static_cast<size_t>(i);
}

Vector3d edge_tangent(const std::vector<Vector3d>& x, int edge) {
    return (x[at(edge) + 1] - x[at(edge)]).normalized();
}

Vector3d curvature_binormal(const std::vector<Vector3d>& x, int node) {
    const Vector3d e0 = x[at(node)] - x[at(node) - 1], e1 = x[at(node) + 1] - x[at(node)];
    return 2.0 * e0.cross(e1) / (e0.norm() * e1.norm() + e0.dot(e1));
}

Vector3d turned(const Vector3d& m, const Vector3d& t, double angle_rad) {
    return std::cos(angle_rad) * m + std::sin(angle_rad) * t.cross(m);
}

}  // namespace

/// Between edges node - 1 and node. The curvature about the second director of an edge rolled by `r` is
/// cos(r) about - sin(r) across.
struct RodMemory::Joint {
    int node;
    Vector3d kb;
    double about[2], across[2];
    double pull;         ///< EI k0 / l
    double twist_N_m;    ///< GJ / l
    double at_rest_rad;  ///< twist when both rolls are zero
};

struct RodMemory::Frames {
    std::vector<Vector3d> tangent, director;  // directors with their rolls
    std::vector<Joint> joints;
    double energy_J = 0.0;
};

void RodMemory::reset(const ThreadState& state, const Stiffness& stiffness) {
    stiffness_ = stiffness;
    held_.clear();
    director_W_.assign(at(std::max(state.edge_count(), 0)), Vector3d::Zero());
    tangent_W_ = director_W_;
    if (!is_on()) return;
    Vector3d bent = Vector3d::Zero();
    for (int i = 1; i < state.edge_count(); ++i)
        if (state.has_edge(i - 1) && state.has_edge(i)) bent += curvature_binormal(state.p_W, i);
    for (int i = 0; i < state.edge_count(); ++i) {
        Vector3d& t = tangent_W_[at(i)];
        t = edge_tangent(state.p_W, i);
        if (!t.allFinite()) t = Vector3d::UnitX();  // between two strands
        if (i > 0) {
            director_W_[at(i)] = transport(director_W_[at(i) - 1], tangent_W_[at(i) - 1], t);
            continue;
        }
        Vector3d axis = bent - bent.dot(t) * t;
        if (axis.norm() < 1e-6) axis = t.unitOrthogonal();
        director_W_[0] = axis.normalized().cross(t);
    }
}

void RodMemory::insert(int edge, int added) {
    if (!is_on()) return;
    const auto here = static_cast<std::ptrdiff_t>(edge);
    director_W_.insert(director_W_.begin() + here, at(added), Vector3d(director_W_[at(edge)]));
    tangent_W_.insert(tangent_W_.begin() + here, at(added), Vector3d(tangent_W_[at(edge)]));
    for (auto& [id, roll] : held_)
        if (roll.edge >= edge) roll.edge += added;
}

void RodMemory::hold(const ThreadState& state, const std::vector<HeldRoll>& rolls) {
    if (!is_on()) return;
    std::map<int, Roll> held;
    for (const HeldRoll& now : rolls) {
        const auto known = held_.find(now.grip);
        Roll roll{now.edge, 0.0, now.m_W};
        if (known != held_.end() && known->second.edge == now.edge) {
            roll.angle_rad = known->second.angle_rad;
        } else {
            const Vector3d t = edge_tangent(state.p_W, now.edge);
            const Vector3d m = (now.m_W - now.m_W.dot(t) * t).normalized();
            roll.angle_rad = signed_angle_rad(m, director_W_[at(now.edge)], t);
        }
        held.emplace(now.grip, roll);
    }
    held_ = std::move(held);
}

double RodMemory::energy_of(const std::vector<Joint>& joints, const std::vector<double>& roll_rad) const {
    double sum = 0.0;
    for (const Joint& j : joints) {
        for (int k = 0; k < 2; ++k) {
            const double r = roll_rad[at(j.node - 1 + k)];
            sum -= 0.5 * j.pull * (std::cos(r) * j.about[k] - std::sin(r) * j.across[k]);
        }
        const double twist = roll_rad[at(j.node)] - roll_rad[at(j.node) - 1] + j.at_rest_rad;
        sum += 0.5 * j.twist_N_m * twist * twist;
    }
    return sum;
}

/// Tridiagonal, by the Thomas algorithm; curvature of the pull counted by its size, so that it is definite.
void RodMemory::newton_step(const std::vector<Joint>& joints, const std::vector<char>& fixed,
                            const std::vector<double>& roll_rad, std::vector<double>& step) const {
    const size_t n = roll_rad.size();
    std::vector<double> gradient(n, 0.0), diagonal(n, 1e-12 * stiffness_.GJ_N_m2 + 1e-30), coupling(n, 0.0);
    for (const Joint& j : joints) {
        const size_t edges[2] = {at(j.node) - 1, at(j.node)};
        const double twist = roll_rad[edges[1]] - roll_rad[edges[0]] + j.at_rest_rad;
        for (int k = 0; k < 2; ++k) {
            const double r = roll_rad[edges[k]], sign = k == 0 ? -1.0 : 1.0;
            gradient[edges[k]] += 0.5 * j.pull * (std::sin(r) * j.about[k] + std::cos(r) * j.across[k]) +
                                  sign * j.twist_N_m * twist;
            diagonal[edges[k]] +=
                0.5 * j.pull * std::abs(std::cos(r) * j.about[k] - std::sin(r) * j.across[k]) + j.twist_N_m;
        }
        coupling[edges[1]] -= j.twist_N_m;  // with the edge before
    }
    for (size_t i = 0; i < n; ++i) {
        if (!fixed[i]) continue;
        gradient[i] = 0.0;
        diagonal[i] = 1.0;
        coupling[i] = 0.0;
        if (i + 1 < n) coupling[i + 1] = 0.0;
    }
    step.resize(n);
    for (size_t i = 0; i < n; ++i) {
        const double factor = i > 0 ? coupling[i] / diagonal[i - 1] : 0.0;
        if (i > 0) diagonal[i] -= factor * coupling[i];
        step[i] = -gradient[i] - (i > 0 ? factor * step[i - 1] : 0.0);
    }
    for (size_t i = n; i-- > 0;) {
        if (i + 1 < n) step[i] -= coupling[i + 1] * step[i + 1];
        step[i] /= diagonal[i];
    }
}

RodMemory::Frames RodMemory::solved(const ThreadState& state, const std::vector<Vector3d>& x) const {
    const int edges = state.edge_count();
    Frames f;
    f.tangent.resize(at(edges));
    f.director.resize(at(edges));
    std::vector<double> roll_rad(at(edges), 0.0), step;
    std::vector<char> fixed(at(edges), 0);
    for (int i = 0; i < edges; ++i) {
        f.tangent[at(i)] = state.has_edge(i) ? edge_tangent(x, i) : tangent_W_[at(i)];
        f.director[at(i)] = transport(director_W_[at(i)], tangent_W_[at(i)], f.tangent[at(i)]);
        fixed[at(i)] = !state.has_edge(i);
    }
    for (const auto& [id, held] : held_) {
        const Vector3d& t = f.tangent[at(held.edge)];
        const Vector3d m = (held.m_W - held.m_W.dot(t) * t).normalized();
        roll_rad[at(held.edge)] =
            signed_angle_rad(f.director[at(held.edge)], turned(m, t, held.angle_rad), t);
        fixed[at(held.edge)] = 1;
    }
    for (int i = 1; i < edges; ++i) {
        if (!state.has_edge(i - 1) || !state.has_edge(i)) continue;
        const double l = 0.5 * (state.rest_length_m(i - 1) + state.rest_length_m(i));
        Joint j;
        j.node = i;
        j.kb = curvature_binormal(x, i);
        for (int k = 0; k < 2; ++k) {
            const Vector3d &d = f.director[at(i - 1 + k)], &t = f.tangent[at(i - 1 + k)];
            j.about[k] = t.cross(d).dot(j.kb);
            j.across[k] = d.dot(j.kb);
        }
        j.pull = stiffness_.EI_N_m2 / l * 2.0 * std::tan(0.5 * stiffness_.natural_curvature_per_m * l);
        j.twist_N_m = stiffness_.GJ_N_m2 / l;
        j.at_rest_rad =
            signed_angle_rad(transport(f.director[at(i) - 1], f.tangent[at(i) - 1], f.tangent[at(i)]),
                             f.director[at(i)], f.tangent[at(i)]);
        f.joints.push_back(j);
    }
    f.energy_J = energy_of(f.joints, roll_rad);
    std::vector<double> trial(roll_rad.size());
    for (int iteration = 0; iteration < 30; ++iteration) {
        newton_step(f.joints, fixed, roll_rad, step);
        double share = 1.0, largest = 0.0;
        for (const double s : step) largest = std::max(largest, std::abs(s));
        for (int halving = 0; halving < 10; ++halving, share *= 0.5) {
            for (size_t i = 0; i < step.size(); ++i) trial[i] = roll_rad[i] + share * step[i];
            if (energy_of(f.joints, trial) <= f.energy_J) break;
        }
        const double energy = energy_of(f.joints, trial);
        if (energy > f.energy_J) break;
        f.energy_J = energy;
        roll_rad.swap(trial);
        if (largest < 1e-9) break;
    }
    for (size_t i = 0; i < roll_rad.size(); ++i)
        f.director[i] = turned(f.director[i], f.tangent[i], roll_rad[i]);
    return f;
}

double RodMemory::energy_J(const ThreadState& state, const std::vector<Vector3d>& x) const {
    return is_on() ? solved(state, x).energy_J : 0.0;
}

// Rolls stand at their best, so that only what moves with the nodes counts: curvature (Bergou et al. 2010)
// and the twist that parallel transport leaves (Bergou et al. 2008, eq. 9).
void RodMemory::add_gradient(const ThreadState& state, const std::vector<Vector3d>& x,
                             Eigen::VectorXd& gradient) const {
    if (!is_on()) return;
    const Frames f = solved(state, x);
    for (const Joint& j : f.joints) {
        const size_t i0 = at(j.node) - 1, i1 = at(j.node);
        const Vector3d &t0 = f.tangent[i0], &t1 = f.tangent[i1];
        const double n0 = (x[i0 + 1] - x[i0]).norm(), n1 = (x[i1 + 1] - x[i1]).norm();
        const double chi = 1.0 + t0.dot(t1);
        const Vector3d m2 = t0.cross(f.director[i0]) + t1.cross(f.director[i1]);
        const double curvature = 0.5 * m2.dot(j.kb);
        const Vector3d middle = (t0 + t1) / chi;
        const Vector3d by_e0 = (-curvature * middle + t1.cross(m2) / chi) / n0;
        const Vector3d by_e1 = (-curvature * middle - t0.cross(m2) / chi) / n1;
        const double torque =
            j.twist_N_m * signed_angle_rad(transport(f.director[i0], t0, t1), f.director[i1], t1);
        const Vector3d g0 = -j.pull * by_e0 + torque * j.kb / (2.0 * n0);
        const Vector3d g1 = -j.pull * by_e1 + torque * j.kb / (2.0 * n1);
        gradient.segment<3>(3 * j.node - 3) -= g0;
        gradient.segment<3>(3 * j.node) += g0 - g1;
        gradient.segment<3>(3 * j.node + 3) += g1;
    }
}

void RodMemory::accept(const ThreadState& state, const std::vector<Vector3d>& x) {
    if (!is_on()) return;
    Frames f = solved(state, x);
    tangent_W_ = std::move(f.tangent);
    director_W_ = std::move(f.director);
}

Vector3d RodMemory::curl_axis_W(int edge) const {
    return tangent_W_[at(edge)].cross(director_W_[at(edge)]);
}

}  // namespace atropos::sim
