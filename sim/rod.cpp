#include "sim/rod.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "sim/rod_energy.hpp"
#include "sim/rod_substep.hpp"

namespace atropos::sim {

using Eigen::Vector3d;

namespace {

constexpr int kMaxHalvings = 7;  // of a step in which thread came through thread
constexpr int kMaxLineSearch = 12;
constexpr double kDeepest = 0.955;       // diameters two axes may come near before the step is halved
constexpr double kContactMargin = 0.35;  // diameters at which a pair of edges becomes a contact

size_t at(int i) {
    return static_cast<size_t>(i);
}

}  // namespace

Rod::Rod(ThreadState initial, const RodParameters& parameters) : parameters_(parameters) {
    set_state(initial);
}

void Rod::set_state(const ThreadState& state) {
    for (int i = 0; i < state.edge_count(); ++i)
        if (state.has_edge(i) && !(state.rest_length_m(i) > 0.0))
            throw std::invalid_argument("Rod: edge of no length, expected increasing arc length");
    const bool same_edges = !mass_kg_.empty() && state.p_W.size() == state_.p_W.size();
    state_ = state;
    if (same_edges)
        memory_.accept(state_, state_.p_W);
    else
        memory_.reset(state_,
                      {parameters_.natural_curvature_per_m, parameters_.EI_N_m2, parameters_.GJ_N_m2});
    set_masses();
    pull_N_.assign(state_.p_W.size(), Vector3d::Zero());
    self_contact_.clear();
    past_contacts_.clear();
    last_v_W_.clear();
}

void Rod::cut(int edge, double t) {
    ThreadDynamics::cut(edge, t);
    memory_.insert(t == 1.0 ? edge + 1 : edge, t == 0.0 || t == 1.0 ? 1 : 2);
    set_masses();
    pull_N_.assign(state_.p_W.size(), Vector3d::Zero());
    self_contact_.clear();
    past_contacts_.clear();
    last_v_W_.clear();
}

void Rod::set_masses() {
    mass_kg_.assign(state_.p_W.size(), 0.0);
    for (int i = 0; i < state_.edge_count(); ++i) {
        if (!state_.has_edge(i)) continue;
        const double half = 0.5 * parameters_.linear_density_kg_m * state_.rest_length_m(i);
        mass_kg_[at(i)] += half;
        mass_kg_[at(i) + 1] += half;
    }
}

double Rod::mass_kg() const {
    double sum = 0.0;
    for (const double m : mass_kg_) sum += m;
    return sum;
}

Vector3d Rod::momentum_kg_m_s() const {
    Vector3d sum = Vector3d::Zero();
    for (size_t i = 0; i < mass_kg_.size(); ++i) sum += mass_kg_[i] * state_.v_W[i];
    return sum;
}

double Rod::tension_N(int edge) const {
    if (!state_.has_edge(edge)) return 0.0;
    const Vector3d e = state_.p_W[at(edge) + 1] - state_.p_W[at(edge)];
    return parameters_.EA_N * (e.norm() / state_.rest_length_m(edge) - 1.0);
}

Vector3d Rod::pull_on_node_N(int node) const {
    return pull_N_[at(node)];
}

void Rod::step(double dt_s, Boundary& boundary, std::vector<SurfaceContact>& contacts) {
    report_ = {};
    const ThreadState before_tick = state_;
    std::vector<double> impulse(contacts.size(), 0.0);
    double done = 0.0, h = dt_s;
    int halvings = 0;
    memory_.hold(state_, boundary.rolls);
    while (done < dt_s * (1.0 - 1e-9)) {
        Substep sub;
        sub.h = std::min(h, dt_s - done);
        sub.x_start = state_.p_W;
        sub.boundary = &boundary;
        sub.fixed.assign(state_.p_W.size(), 0);
        sub.x_inertial.resize(state_.p_W.size());
        for (size_t i = 0; i < state_.p_W.size(); ++i)
            sub.x_inertial[i] =
                state_.p_W[i] + sub.h * state_.v_W[i] + sub.h * sub.h * parameters_.gravity_W_m_s2;
        x_ = state_.p_W;
        for (size_t i = 0; i < x_.size(); ++i) x_[i] += sub.h * state_.v_W[i];
        for (const PrescribedNode& p : boundary.nodes) {
            const double part = (done + sub.h) / dt_s;
            x_[at(p.node)] = before_tick.p_W[at(p.node)] + part * (p.p_W - before_tick.p_W[at(p.node)]);
            sub.fixed[at(p.node)] = 1;
        }
        sub.contacts = contacts;
        for (SurfaceContact& c : sub.contacts) c.p_surface_W -= (dt_s - done - sub.h) * c.v_surface_W;
        sub.lagged_normal_N.assign(contacts.size(), 0.0);

        const std::vector<TwistSpan> twists = boundary.twists;
        const bool sound = advance(sub);
        if ((!sound || came_through_itself(sub)) && halvings < kMaxHalvings) {
            ++halvings, ++report_.rejected_steps;
            h = 0.5 * sub.h;
            boundary.twists = twists;
            continue;
        }
        for (size_t i = 0; i < x_.size(); ++i) {
            state_.v_W[i] = (x_[i] - sub.x_start[i]) / sub.h;
            state_.p_W[i] = x_[i];
            pull_N_[i] = sub.fixed[i] ? Vector3d(-gradient_.segment<3>(3 * static_cast<int>(i)) +
                                                 sub.multiplier_force.segment<3>(3 * static_cast<int>(i)))
                                      : Vector3d::Zero();
        }
        memory_.accept(state_, state_.p_W);
        remember_contacts(sub);
        for (size_t c = 0; c < contacts.size(); ++c) impulse[c] += sub.h * past_contacts_[c].normal_N;
        done += sub.h;
    }
    last_v_W_ = before_tick.v_W;
    for (size_t c = 0; c < contacts.size(); ++c) contacts[c].normal_force_N = impulse[c] / dt_s;
}

bool Rod::advance(Substep& sub) {
    const int rows = 3 * state_.node_count();
    sub.multiplier_force = Eigen::VectorXd::Zero(rows);
    std::vector<EdgePair> near;
    if (parameters_.self_contact) {
        double fastest = 0.0;
        for (size_t i = 0; i < x_.size(); ++i) fastest = std::max(fastest, (x_[i] - sub.x_start[i]).norm());
        near = near_edge_pairs(state_, sub.x_start, parameters_.diameter_m,
                               (1.0 + kContactMargin) * parameters_.diameter_m + 2.0 * fastest);
    }
    self_contact_.begin_step(near);

    lag_friction(sub);
    sub.at_x = potential(sub, x_);
    if (near.empty()) try_gathering_speed(sub);
    bool converged = false;
    double before_m = 0.0;
    for (int iteration = 0;; ++iteration) {
        const bool touching = !near.empty() && self_contact_.count() > 0;
        const int most = touching ? parameters_.max_newton_in_contact
                         : sub.contacts.empty()
                             ? parameters_.max_newton
                             : std::max(parameters_.max_newton, parameters_.max_newton_on_surface);
        if (iteration >= most || converged) break;
        ++report_.newton_iterations;
        assemble(sub, true);
        for (int i = 0; i < state_.node_count(); ++i)
            if (sub.fixed[at(i)]) matrix_.fix_node(i);
        if (!matrix_.factor()) return false;
        direction_ = -gradient_;
        zero_where_fixed(sub, direction_);
        matrix_.solve(direction_);
        if (!near.empty()) solve_self_contacts(sub, sub.multiplier_force);
        if (self_contact_.count() == 0) stiffen_by_twist(sub);
        const double slope = (gradient_ - sub.multiplier_force).dot(direction_);
        if (!search_line(sub, slope)) return false;
        const double tolerance =
            self_contact_.count() > 0 ? parameters_.contact_tolerance_m : parameters_.tolerance_m;
        const double moved_m = direction_.lpNorm<Eigen::Infinity>();
        // Steps shrink at least in proportion: where the next would be a tenth of the tolerance it is not
        // needed.
        converged = moved_m <= tolerance || (self_contact_.count() == 0 && sub.contacts.empty() &&
                                             moved_m * moved_m <= 0.1 * tolerance * before_m);
        before_m = moved_m;
    }
    report_.converged = converged;
    report_.self_contacts = near.empty() ? 0 : self_contact_.count();
    assemble(sub, false);
    for (size_t k = 0; k < sub.at_x.twist_rad.size(); ++k)
        sub.boundary->twists[k].twist_rad = sub.at_x.twist_rad[k];
    return gradient_.allFinite();
}

void Rod::try_gathering_speed(Substep& sub) {
    if (last_v_W_.size() != x_.size()) return;
    trial_ = x_;
    for (size_t i = 0; i < x_.size(); ++i)
        if (!sub.fixed[i]) trial_[i] += sub.h * (state_.v_W[i] - last_v_W_[i]);
    Potential there = potential(sub, trial_);
    if (!(there.total_J < sub.at_x.total_J)) return;
    x_.swap(trial_);
    sub.at_x = std::move(there);
}

void Rod::solve_self_contacts(Substep& sub, Eigen::VectorXd& multiplier_force) {
    self_contact_.find(x_, sub.x_start, parameters_.diameter_m, kContactMargin * parameters_.diameter_m);
    multiplier_force.setZero();
    if (self_contact_.empty()) return;
    multiplier_force = self_contact_.solve(matrix_, direction_, parameters_.self_friction, sub.fixed);
    direction_ = multiplier_force - gradient_;
    zero_where_fixed(sub, direction_);
    matrix_.solve(direction_);
}

void Rod::zero_where_fixed(const Substep& sub, Eigen::VectorXd& rows) const {
    for (int i = 0; i < state_.node_count(); ++i)
        if (sub.fixed[at(i)]) rows.segment<3>(3 * i).setZero();
}

void Rod::stiffen_by_twist(const Substep& sub) {
    for (size_t k = 0; k < sub.by_twist.size(); ++k) {
        Eigen::VectorXd t(3 * state_.node_count());
        for (int i = 0; i < state_.node_count(); ++i) t.segment<3>(3 * i) = sub.by_twist[k][at(i)];
        zero_where_fixed(sub, t);
        Eigen::VectorXd z = t;
        matrix_.solve(z);
        const double stiffness = parameters_.GJ_N_m2 / span_length_m(sub.boundary->twists[k]);
        direction_ -= stiffness * t.dot(direction_) / (1.0 + stiffness * t.dot(z)) * z;
    }
}

bool Rod::search_line(Substep& sub, double slope) {
    const double start = sub.at_x.total_J;
    if (!std::isfinite(start)) return false;
    trial_.resize(x_.size());
    double alpha = 1.0;
    for (int i = 0; i < kMaxLineSearch; ++i, alpha *= 0.5) {
        double work = 0.0;
        for (size_t n = 0; n < x_.size(); ++n) {
            const Vector3d d = alpha * direction_.segment<3>(3 * static_cast<int>(n));
            trial_[n] = x_[n] + d;
            work += d.dot(sub.multiplier_force.segment<3>(3 * static_cast<int>(n)));
        }
        sub.at_x = potential(sub, trial_);
        if (sub.at_x.total_J - work <= start + 1e-4 * alpha * slope + 1e-14 * std::abs(start)) break;
    }
    x_.swap(trial_);
    direction_ *= alpha;
    return true;
}

bool Rod::came_through_itself(const Substep& sub) const {
    const double d = parameters_.diameter_m;
    for (const EdgePair& pair : self_contact_.near_pairs()) {
        const EdgeApproach before = edge_approach(sub.x_start, pair), after = edge_approach(x_, pair);
        if (after.distance_m < kDeepest * d && after.distance_m < before.distance_m) return true;
        if (before.from_b_to_a.dot(after.from_b_to_a) < 0.0 && before.distance_m < 3 * d &&
            after.distance_m < 3 * d)
            return true;
    }
    return false;
}

}  // namespace atropos::sim
