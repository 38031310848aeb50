// The incremental potential of one backward-Euler step of the rod, its gradient and its definite Hessian.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "sim/rod_energy.hpp"
#include "sim/rod_substep.hpp"

namespace atropos::sim {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

size_t at(int i) {
    return static_cast<size_t>(i);
}

/// Smoothed Coulomb friction (Li et al. 2020, Incremental Potential Contact, eq. 14): potential of a unit
/// force over the displacement u, smoothed below eps, and its first two derivatives.
double friction_potential(double u, double eps) {
    return u >= eps ? u : u * u / eps * (1.0 - u / (3.0 * eps)) + eps / 3.0;
}
double friction_slope(double u, double eps) {
    return u >= eps ? 1.0 : u / eps * (2.0 - u / eps);
}
double friction_curvature(double u, double eps) {
    return u >= eps ? 0.0 : 2.0 / eps * (1.0 - u / eps);
}

/// Where the contact's point of the thread is, and how far it slid along the surface in this step.
struct ContactPoint {
    double gap_m;
    Vector3d slid;
    ContactPoint(const SurfaceContact& c, const std::vector<Vector3d>& x,
                 const std::vector<Vector3d>& x_start, double h, double radius_m) {
        const size_t i = at(c.edge);
        const Vector3d p = (1.0 - c.t) * x[i] + c.t * x[i + 1];
        const Vector3d from = (1.0 - c.t) * x_start[i] + c.t * x_start[i + 1];
        gap_m = c.normal_W.dot(p - c.p_surface_W) - radius_m;
        const Vector3d moved = p - from - h * c.v_surface_W;
        slid = moved - c.normal_W.dot(moved) * c.normal_W;
    }
};

}  // namespace

double Rod::elastic_energy(const std::vector<Vector3d>& x) const {
    double sum = 0.0;
    for (int i = 0; i < state_.edge_count(); ++i) {
        if (!state_.has_edge(i)) continue;
        const Vector3d e = x[at(i) + 1] - x[at(i)];
        const double rest = state_.rest_length_m(i);
        sum += Stretch::energy(e, rest, parameters_.EA_N);
        if (!state_.has_edge(i - 1)) continue;
        const double rest_before = state_.rest_length_m(i - 1);
        const CurvatureBinormal c(x[at(i)] - x[at(i) - 1], e, rest_before, rest);
        sum += parameters_.EI_N_m2 / (rest_before + rest) * c.kb.squaredNorm();
    }
    return sum;
}

double Rod::span_length_m(const TwistSpan& span) const {
    const auto middle = [&](int edge) { return 0.5 * (state_.s_m[at(edge)] + state_.s_m[at(edge) + 1]); };
    return middle(span.last_edge) - middle(span.first_edge);
}

double Rod::twist_at(const TwistSpan& span, const std::vector<Vector3d>& x) const {
    Vector3d t = (x[at(span.first_edge) + 1] - x[at(span.first_edge)]).normalized();
    Vector3d m = span.m_first_W;
    for (int i = span.first_edge + 1; i <= span.last_edge; ++i) {
        const Vector3d next = (x[at(i) + 1] - x[at(i)]).normalized();
        m = transport(m, t, next);
        t = next;
    }
    const double angle = signed_angle_rad(m, span.m_last_W, t);
    return angle + 2.0 * std::numbers::pi * std::round((span.twist_rad - angle) / (2.0 * std::numbers::pi));
}

std::vector<double> Rod::twists(const Boundary& boundary, const std::vector<Vector3d>& x) const {
    std::vector<double> result;
    for (const TwistSpan& span : boundary.twists) result.push_back(twist_at(span, x));
    return result;
}

double Rod::twist_energy(const Boundary& boundary, const std::vector<double>& twist_rad,
                         const std::vector<Vector3d>& x) const {
    if (memory_.is_on()) return memory_.energy_J(state_, x);
    double sum = 0.0;
    for (size_t k = 0; k < twist_rad.size(); ++k)
        sum += 0.5 * parameters_.GJ_N_m2 / span_length_m(boundary.twists[k]) * twist_rad[k] * twist_rad[k];
    return sum;
}

double Rod::surface_potential(const Substep& sub, const std::vector<Vector3d>& x) const {
    double sum = 0.0;
    const double eps = parameters_.friction_speed_m_s * sub.h;
    for (size_t k = 0; k < sub.contacts.size(); ++k) {
        const SurfaceContact& c = sub.contacts[k];
        const ContactPoint point(c, x, sub.x_start, sub.h, 0.5 * parameters_.diameter_m);
        const double depth = std::max(0.0, -point.gap_m);
        sum += 0.5 * parameters_.surface_stiffness_N_m * depth * depth;
        sum += c.friction * sub.lagged_normal_N[k] * friction_potential(point.slid.norm(), eps);
    }
    return sum;
}

Rod::Potential Rod::potential(const Substep& sub, const std::vector<Vector3d>& x) const {
    std::vector<double> twist_rad = twists(*sub.boundary, x);
    double sum = elastic_energy(x) + twist_energy(*sub.boundary, twist_rad, x) + surface_potential(sub, x);
    const double inertia = 0.5 / (sub.h * sub.h), drag = 0.5 / sub.h;
    for (size_t i = 0; i < x.size(); ++i) {
        sum += mass_kg_[i] * inertia * (x[i] - sub.x_inertial[i]).squaredNorm();
        sum += node_drag(i) * drag * (x[i] - sub.x_start[i]).squaredNorm();
    }
    return {sum, std::move(twist_rad)};
}

void Rod::lag_friction(Substep& sub) const {
    // Friction goes by the normal forces of the last step, so that it stays a fixed convex potential in this
    // one.
    for (size_t k = 0; k < sub.contacts.size(); ++k) {
        const SurfaceContact& c = sub.contacts[k];
        const auto same = [&](const auto& other) { return other.edge == c.edge && other.body == c.body; };
        const auto sharing = std::count_if(sub.contacts.begin(), sub.contacts.end(), same);
        double before = 0.0;
        for (const PastContact& past : past_contacts_)
            if (same(past)) before += past.normal_N;
        sub.lagged_normal_N[k] = before / static_cast<double>(sharing);
    }
}

void Rod::remember_contacts(const Substep& sub) {
    past_contacts_.clear();
    for (const SurfaceContact& c : sub.contacts) {
        const ContactPoint point(c, x_, sub.x_start, sub.h, 0.5 * parameters_.diameter_m);
        past_contacts_.push_back(
            {c.edge, c.body, parameters_.surface_stiffness_N_m * std::max(0.0, -point.gap_m)});
    }
}

void Rod::assemble(Substep& sub, bool with_hessian) {
    gradient_.setZero(3 * state_.node_count());
    if (with_hessian) matrix_.reset(3 * state_.node_count());
    add_inertia_terms(sub, with_hessian);
    add_elastic_terms(with_hessian);
    add_twist_gradient(sub);
    add_surface_terms(sub, with_hessian);
}

void Rod::add_inertia_terms(const Substep& sub, bool with_hessian) {
    for (int i = 0; i < state_.node_count(); ++i) {
        const double inertia = mass_kg_[at(i)] / (sub.h * sub.h), drag = node_drag(at(i)) / sub.h;
        gradient_.segment<3>(3 * i) += inertia * (x_[at(i)] - sub.x_inertial[at(i)]);
        gradient_.segment<3>(3 * i) += drag * (x_[at(i)] - sub.x_start[at(i)]);
        if (with_hessian) matrix_.add_diagonal(i, inertia + drag);
    }
}

void Rod::add_elastic_terms(bool with_hessian) {
    for (int i = 0; i < state_.edge_count(); ++i) {
        if (!state_.has_edge(i)) continue;
        const Vector3d e1 = x_[at(i) + 1] - x_[at(i)];
        const double l1 = state_.rest_length_m(i);
        const Stretch stretch(e1, l1, parameters_.EA_N);
        gradient_.segment<3>(3 * i) -= stretch.force;
        gradient_.segment<3>(3 * i + 3) += stretch.force;
        if (with_hessian) {
            const Matrix3d H = stretch.hessian();
            matrix_.add_block(i, i, H);
            matrix_.add_block(i + 1, i, -H);
            matrix_.add_block(i + 1, i + 1, H);
        }
        if (!state_.has_edge(i - 1)) continue;
        const Vector3d e0 = x_[at(i)] - x_[at(i) - 1];
        const double l0 = state_.rest_length_m(i - 1);
        const CurvatureBinormal c(e0, e1, l0, l1);
        const double stiffness = 2.0 * parameters_.EI_N_m2 / (l0 + l1);
        const BendingGradient bending(c, e0, e1);
        const Vector3d g0 = stiffness * bending.by_e0, g1 = stiffness * bending.by_e1;
        gradient_.segment<3>(3 * i - 3) -= g0;
        gradient_.segment<3>(3 * i) += g0 - g1;
        gradient_.segment<3>(3 * i + 3) += g1;
        if (with_hessian) {
            const auto [H00, H10, H11] = BendingHessian(c, e0, e1, stiffness);
            matrix_.add_block(i - 1, i - 1, H00);
            matrix_.add_block(i, i - 1, H10 - H00);
            matrix_.add_block(i + 1, i - 1, -H10);
            matrix_.add_block(i, i, H00 - H10 - H10.transpose() + H11);
            matrix_.add_block(i + 1, i, H10 - H11);
            matrix_.add_block(i + 1, i + 1, H11);
        }
    }
}

std::vector<Vector3d> Rod::twist_gradient(const TwistSpan& span, const std::vector<Vector3d>& x) const {
    std::vector<Vector3d> result(x.size(), Vector3d::Zero());
    for (int i = span.first_edge + 1; i <= span.last_edge; ++i) {
        // The angle by which parallel transport turns, by the nodes (Bergou et al. 2008, eq. 9).
        const Vector3d e0 = x[at(i)] - x[at(i) - 1], e1 = x[at(i) + 1] - x[at(i)];
        const double n0 = e0.norm(), n1 = e1.norm();
        const Vector3d kb = 2.0 * e0.cross(e1) / (n0 * n1 + e0.dot(e1));
        const Vector3d by_first = -kb / (2.0 * n0), by_last = kb / (2.0 * n1);
        result[at(i) - 1] += by_first;
        result[at(i)] -= by_first + by_last;
        result[at(i) + 1] += by_last;
    }
    return result;
}

void Rod::add_twist_gradient(Substep& sub) {
    if (memory_.is_on()) return memory_.add_gradient(state_, x_, gradient_);
    sub.by_twist.clear();
    for (size_t k = 0; k < sub.boundary->twists.size(); ++k) {
        const TwistSpan& span = sub.boundary->twists[k];
        const double torque = parameters_.GJ_N_m2 / span_length_m(span) * sub.at_x.twist_rad[k];
        sub.by_twist.push_back(twist_gradient(span, x_));
        for (int i = span.first_edge; i <= span.last_edge + 1; ++i)
            gradient_.segment<3>(3 * i) += torque * sub.by_twist[k][at(i)];
    }
}

void Rod::add_surface_terms(const Substep& sub, bool with_hessian) {
    const double eps = parameters_.friction_speed_m_s * sub.h;
    for (size_t k = 0; k < sub.contacts.size(); ++k) {
        const SurfaceContact& c = sub.contacts[k];
        const ContactPoint point(c, x_, sub.x_start, sub.h, 0.5 * parameters_.diameter_m);
        const double depth = std::max(0.0, -point.gap_m);
        const double limit = c.friction * sub.lagged_normal_N[k];
        if (depth == 0.0 && limit == 0.0) continue;
        const Vector3d& n = c.normal_W;
        const double u = point.slid.norm();
        Vector3d force = -parameters_.surface_stiffness_N_m * depth * n;
        Vector3d along = Vector3d::Zero();
        double secant = 2.0 / eps;
        if (u > 1e-6 * eps) {
            along = point.slid / u;
            secant = friction_slope(u, eps) / u;
            force += limit * friction_slope(u, eps) * along;
        }
        const double weight[2] = {1.0 - c.t, c.t};
        for (int a = 0; a < 2; ++a) gradient_.segment<3>(3 * (c.edge + a)) += weight[a] * force;
        if (!with_hessian) continue;
        Matrix3d H = limit * secant * (Matrix3d::Identity() - n * n.transpose() - along * along.transpose());
        H += limit * (along.isZero() ? 0.0 : friction_curvature(u, eps)) * along * along.transpose();
        if (depth > 0.0) H += parameters_.surface_stiffness_N_m * n * n.transpose();
        matrix_.add_block(c.edge, c.edge, weight[0] * weight[0] * H);
        matrix_.add_block(c.edge + 1, c.edge, weight[0] * weight[1] * H);
        matrix_.add_block(c.edge + 1, c.edge + 1, weight[1] * weight[1] * H);
    }
}

double Rod::energy_J(const Boundary& boundary) const {
    double sum =
        elastic_energy(state_.p_W) + twist_energy(boundary, twists(boundary, state_.p_W), state_.p_W);
    for (size_t i = 0; i < mass_kg_.size(); ++i)
        sum +=
            mass_kg_[i] * (0.5 * state_.v_W[i].squaredNorm() - parameters_.gravity_W_m_s2.dot(state_.p_W[i]));
    return sum;
}

}  // namespace atropos::sim
