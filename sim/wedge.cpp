#include "sim/wedge.hpp"

#include <algorithm>
#include <cmath>

namespace atropos::sim {

using Eigen::Vector3d;

namespace {

constexpr double kSameThread_m = 1.5e-3;  // arc length within which trapped thread is known again
constexpr double kLost_m = 1.0e-3;        // outside a face by more than this it has left
constexpr int kSamplesPerEdge = 4;

size_t at(int i) {
    return static_cast<size_t>(i);
}

/// Face of the wedge: side +1 or -1 along x.
Vector3d face_direction(double opening_rad, double side) {
    return {side * std::sin(0.5 * opening_rad), 0.0, std::cos(0.5 * opening_rad)};
}
Vector3d face_normal(double opening_rad, double side) {
    return {-side * std::cos(0.5 * opening_rad), 0.0, std::sin(0.5 * opening_rad)};
}

}  // namespace

double Wedge::half_gap_m(double r_m) const {
    return r_m * std::tan(0.5 * std::clamp(opening_rad, 0.0, 3.0));
}

bool Wedge::spans(const Vector3d& p_F) const {
    const double r = from_pin_m(p_F);
    return std::abs(p_F.y()) <= half_width_m && r >= root_m && r <= length_m;
}

std::vector<WedgePassage> WedgeTrap::passages(const Wedge& wedge, const ThreadState& state, bool blades) {
    std::vector<WedgePassage> result;
    const Eigen::Isometry3d X_FW = wedge.X_WF.inverse();
    const double reach = 2.0 * (wedge.length_m + wedge.half_width_m) + 2e-3;
    for (int i = 0; i < state.edge_count(); ++i) {
        if (!state.has_edge(i)) continue;
        if ((state.p_W[at(i)] - wedge.X_WF.translation()).squaredNorm() > reach * reach) continue;
        const Vector3d a = X_FW * state.p_W[at(i)], b = X_FW * state.p_W[at(i) + 1];
        const auto add = [&](double t) {
            const Vector3d p = (1.0 - t) * a + t * b;
            Wedge flat = wedge;
            if (blades) flat.half_width_m = 1e-6;
            if (flat.spans(p)) result.push_back({i, t, state.s_m[at(i)] + t * state.rest_length_m(i), p});
        };
        if (blades) {
            if ((a.y() < 0.0) != (b.y() < 0.0)) add(a.y() / (a.y() - b.y()));
        } else {
            for (int k = 0; k < kSamplesPerEdge; ++k) add(double(k) / kSamplesPerEdge);
        }
    }
    return result;
}

void WedgeTrap::update(const Wedge& wedge, const ThreadState& state, double radius_m, bool blades) {
    std::vector<WedgePassage> now;
    for (const WedgePassage& passage : passages(wedge, state, blades)) {
        const double gap = wedge.half_gap_m(wedge.from_pin_m(passage.p_F)), x = std::abs(passage.p_F.x());
        const bool known = std::any_of(trapped_.begin(), trapped_.end(), [&](const WedgePassage& old) {
            return std::abs(old.s_m - passage.s_m) < kSameThread_m;
        });
        if ((gap > radius_m && x <= gap) || (known && x <= gap + kLost_m)) now.push_back(passage);
    }
    trapped_ = std::move(now);
}

void WedgeTrap::add_contacts(const Wedge& before, const Wedge& now, const ThreadState& state, double dt_s,
                             double friction, int body, std::vector<SurfaceContact>& contacts) const {
    int last_edge = -1;
    const Eigen::Isometry3d X_FW = now.X_WF.inverse();
    for (const WedgePassage& passage : trapped_) {
        if (passage.edge == last_edge) continue;  // one contact an edge and face
        last_edge = passage.edge;
        const Vector3d p_W =
            (1.0 - passage.t) * state.p_W[at(passage.edge)] + passage.t * state.p_W[at(passage.edge) + 1];
        const Vector3d p_F = X_FW * p_W;
        const double r = std::hypot(now.from_pin_m(p_F), p_F.x());
        for (const double side : {-1.0, 1.0}) {
            const Vector3d pin(0.0, 0.0, -now.pin_to_origin_m), y(0.0, p_F.y(), 0.0);
            SurfaceContact contact;
            contact.edge = passage.edge;
            contact.t = passage.t;
            contact.p_surface_W = now.X_WF * (pin + y + r * face_direction(now.opening_rad, side));
            const Vector3d was = before.X_WF * (pin + y + r * face_direction(before.opening_rad, side));
            contact.v_surface_W = (contact.p_surface_W - was) / dt_s;
            contact.normal_W = now.X_WF.linear() * face_normal(now.opening_rad, side);
            contact.friction = friction;
            contact.body = body;
            contacts.push_back(contact);
        }
    }
}

}  // namespace atropos::sim
