#include "sim/thread_grips.hpp"

#include <algorithm>
#include <cmath>

#include "sim/rod_energy.hpp"

namespace atropos::sim {

using Eigen::Vector3d;

namespace {

size_t at(int i) {
    return static_cast<size_t>(i);
}

Vector3d edge_direction(const ThreadState& state, int edge) {
    return (state.p_W[at(edge) + 1] - state.p_W[at(edge)]).normalized();
}

Vector3d any_across(const Vector3d& t) {
    int small = 0;
    t.cwiseAbs().minCoeff(&small);
    return t.cross(Vector3d::Unit(small)).normalized();
}

bool joined_between(const ThreadState& state, int first_edge, int last_edge) {
    for (int i = first_edge; i <= last_edge; ++i)
        if (!state.has_edge(i)) return false;
    return true;
}

/// The roll reference of `from`, carried along the thread to edge `to`.
Vector3d carried(const ThreadState& state, const Vector3d& m_W, int from, int to) {
    Vector3d m = m_W, t = edge_direction(state, from);
    for (int i = from; i != to;) {
        i += to > from ? 1 : -1;
        const Vector3d next = edge_direction(state, i);
        m = transport(m, t, next);
        t = next;
    }
    return m;
}

}  // namespace

int edge_at(const ThreadState& state, double s_m) {
    const auto above = std::lower_bound(state.s_m.begin(), state.s_m.end(), s_m) - state.s_m.begin();
    if (above == static_cast<std::ptrdiff_t>(state.s_m.size()) || s_m < state.s_m.front()) return -1;
    int edge = std::max(static_cast<int>(above) - 1, 0);
    while (edge > 0 && !state.has_edge(edge)) --edge;
    return edge;
}

const Grip* ThreadGrips::of(int holder) const {
    for (const Grip& grip : grips_)
        if (grip.holder == holder) return &grip;
    return nullptr;
}

void ThreadGrips::add(Grip grip, const ThreadState& state) {
    const auto next =
        std::find_if(grips_.begin(), grips_.end(), [&](const Grip& g) { return g.s_m > grip.s_m; });
    const auto index = static_cast<size_t>(next - grips_.begin());
    grip.number = next_number_++;
    grip.strand_edge = edge_at(state, grip.s_m);
    const Eigen::Matrix3d R_HW = grip.X_WH.linear().transpose();
    const Vector3d t_W = grip.X_WH.linear() * grip.t_H;
    const auto usable = [&](const Grip& other) {
        return other.holds_direction && grip.holds_direction &&
               joined_between(state, std::min(other.strand_edge, grip.strand_edge),
                              std::max(other.strand_edge, grip.strand_edge));
    };
    Vector3d m_W = any_across(t_W);
    if (index > 0 && usable(grips_[index - 1])) {
        Grip& before = grips_[index - 1];
        double share = 0.0;
        if (index < grips_.size() && usable(grips_[index])) {
            share = (grip.s_m - before.s_m) / (grips_[index].s_m - before.s_m);
        }
        const double total = before.twist_to_next_rad;
        before.twist_to_next_rad = share * total;
        grip.twist_to_next_rad = (1.0 - share) * total;
        m_W = carried(state, before.X_WH.linear() * before.m_H, before.strand_edge, grip.strand_edge);
        m_W = Eigen::AngleAxisd(share * total, edge_direction(state, grip.strand_edge)) * m_W;
    } else if (index < grips_.size() && usable(grips_[index])) {
        const Grip& after = grips_[index];
        m_W = carried(state, after.X_WH.linear() * after.m_H, after.strand_edge, grip.strand_edge);
    }
    m_W -= m_W.dot(t_W) * t_W;
    grip.m_H = R_HW * m_W.normalized();
    grips_.insert(grips_.begin() + static_cast<std::ptrdiff_t>(index), grip);
    pull_N_.assign(grips_.size(), Vector3d::Zero());
}

void ThreadGrips::remove(int holder) {
    for (size_t i = 0; i < grips_.size(); ++i) {
        if (grips_[i].holder != holder) continue;
        if (i > 0) grips_[i - 1].twist_to_next_rad += grips_[i].twist_to_next_rad;
        if (i > 0 && i + 1 == grips_.size()) grips_[i - 1].twist_to_next_rad = 0.0;
        grips_.erase(grips_.begin() + static_cast<std::ptrdiff_t>(i));
        pull_N_.assign(grips_.size(), Vector3d::Zero());
        return;
    }
}

void ThreadGrips::move(int holder, const Eigen::Isometry3d& X_WH) {
    for (Grip& grip : grips_)
        if (grip.holder == holder) grip.X_WH = X_WH;
}

Boundary ThreadGrips::boundary(const ThreadState& state) {
    Boundary result;
    held_.assign(grips_.size(), {});
    std::vector<char> taken(state.p_W.size(), 0);
    for (size_t g = 0; g < grips_.size(); ++g) {
        Grip& grip = grips_[g];
        grip.strand_edge = edge_at(state, grip.s_m);
        const Vector3d p_W = grip.X_WH * grip.p_H;
        const Vector3d t_W = grip.X_WH.linear() * grip.t_H;
        const int nearer =
            grip.s_m - state.s_m[at(grip.strand_edge)] > 0.5 * state.rest_length_m(grip.strand_edge);
        for (int k = 0; k < 2; ++k) {
            const int node = grip.strand_edge + k;
            if (taken[at(node)] || (!grip.holds_direction && k != nearer)) continue;
            taken[at(node)] = 1;
            result.nodes.push_back({node, p_W + (state.s_m[at(node)] - grip.s_m) * t_W});
            held_[g].nodes.push_back(node);
        }
    }
    for (const Grip& grip : grips_)
        if (grip.holds_direction)
            result.rolls.push_back({grip.strand_edge, grip.number, grip.X_WH.linear() * grip.m_H});
    span_of_.clear();
    for (size_t g = 0; g + 1 < grips_.size(); ++g) {
        const Grip &a = grips_[g], &b = grips_[g + 1];
        if (!a.holds_direction || !b.holds_direction || b.strand_edge - a.strand_edge < 3) continue;
        if (!joined_between(state, a.strand_edge, b.strand_edge)) continue;
        result.twists.push_back({a.strand_edge, b.strand_edge, a.X_WH.linear() * a.m_H,
                                 b.X_WH.linear() * b.m_H, a.twist_to_next_rad});
        span_of_.push_back(static_cast<int>(g));
    }
    return result;
}

void ThreadGrips::accept(const Boundary& boundary) {
    for (size_t k = 0; k < span_of_.size(); ++k)
        grips_[at(span_of_[k])].twist_to_next_rad = boundary.twists[k].twist_rad;
}

void ThreadGrips::measure(const ThreadDynamics& thread, const Boundary&) {
    pull_N_.assign(grips_.size(), Vector3d::Zero());
    for (size_t g = 0; g < grips_.size(); ++g)
        for (const int node : held_[g].nodes) pull_N_[g] += thread.pull_on_node_N(node);
}

Vector3d ThreadGrips::pull_W_N(int holder) const {
    for (size_t g = 0; g < grips_.size(); ++g)
        if (grips_[g].holder == holder) return pull_N_[g];
    return Vector3d::Zero();
}

std::optional<SlidGrip> ThreadGrips::slide(const ThreadDynamics& thread, double dt_s) {
    constexpr double kMostSpeed_m_s = 0.25, kStopsWithin = 0.01;
    const ThreadState& state = thread.state();
    Grip* yielding = nullptr;
    double yielding_along_N = 0.0, yielding_ratio = 1.0;
    for (size_t g = 0; g < grips_.size(); ++g) {
        Grip& grip = grips_[g];
        if (grip.holder < 0) continue;
        const double along = pull_N_[g].dot(grip.X_WH.linear() * grip.t_H);
        const double sliding_limit = kSlidingShare * grip.slip_limit_N;
        if (grip.slipping && std::abs(along) <= (1.0 + kStopsWithin) * sliding_limit) grip.slipping = false;
        const double ratio = std::abs(along) / (grip.slipping ? sliding_limit : grip.slip_limit_N);
        if (ratio <= yielding_ratio) continue;
        yielding = &grip;
        yielding_along_N = along;
        yielding_ratio = ratio;
    }
    if (!yielding) return std::nullopt;
    const bool begins = !yielding->slipping;
    yielding->slipping = true;
    // The pull falls by EA/L a metre of thread let through; half of what would restore the limit, so that it
    // never falls short. Thread that is pulled forward lowers s at the jaw.
    const double excess = std::abs(yielding_along_N) - kSlidingShare * yielding->slip_limit_N;
    const double compliance =
        (state.s_m.back() - state.s_m.front()) / std::max(thread.axial_stiffness_N(), 1e-9);
    const double distance = std::min(0.5 * excess * compliance, kMostSpeed_m_s * dt_s);
    yielding->s_m -= std::copysign(distance, yielding_along_N);
    return SlidGrip{yielding, begins};
}

void ThreadGrips::forget_twist_across(double s_m) {
    for (size_t g = 0; g + 1 < grips_.size(); ++g)
        if (grips_[g].s_m <= s_m && grips_[g + 1].s_m >= s_m) grips_[g].twist_to_next_rad = 0.0;
}

}  // namespace atropos::sim
