// Jaws that catch, hold and let go; blades that cut.

#include <algorithm>
#include <cmath>

#include "sim/world_impl.hpp"

namespace atropos::sim {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

constexpr double kReleaseGap = 1.5;  // diameters of room at which jaws let go
constexpr double kSnap = 0.05;       // of an edge: a cut this near to a node goes through the node

size_t at(int i) {
    return static_cast<size_t>(i);
}

}  // namespace

void World::Impl::slide_grips(double dt_s) {
    const std::optional<SlidGrip> slid = grips.slide(*thread, dt_s);
    if (!slid) return;
    const Grip grip = *slid->grip;
    const double pull = grips.pull_W_N(grip.holder).norm();
    if (slid->begins) report_on_thread(EventKind::kSlip, grip.holder, grip.s_m, pull);
    // Past its strand's end the thread has slipped out of the jaws.
    const int edge = edge_at(thread->state(), grip.s_m);
    bool out = edge < 0;
    for (int i = std::min(edge, grip.strand_edge); !out && i <= std::max(edge, grip.strand_edge); ++i)
        out = !thread->state().has_edge(i);
    if (!out) return;
    report_on_thread(EventKind::kRelease, grip.holder, grip.s_m, pull);
    grips.remove(grip.holder);
}

void World::Impl::work_jaws(int index) {
    Instrument& n = instruments[at(index)];
    if (!n.jaws_set) return;
    const double diameter = thread_options.diameter_m;
    if (const Grip* grip = grips.of(index)) {
        const double r = n.jaws.from_pin_m(grip->p_H);
        if (2.0 * n.jaws.half_gap_m(r) > kReleaseGap * diameter) {
            report_on_thread(EventKind::kRelease, index, grip->s_m);
            grips.remove(index);
        }
        return;
    }
    n.between_jaws.update(n.jaws, thread->state(), radius_m(), false);
    const WedgePassage* best = nullptr;  // of what both jaws touch, the one nearest to the grip point
    for (const WedgePassage& p : n.between_jaws.trapped()) {
        if (2.0 * n.jaws.half_gap_m(n.jaws.from_pin_m(p.p_F)) > diameter) continue;
        if (!best || p.p_F.squaredNorm() < best->p_F.squaredNorm()) best = &p;
    }
    if (!best) return;
    Grip grip;
    grip.holder = index;
    grip.s_m = best->s_m;
    grip.X_WH = n.jaws.X_WF;
    grip.p_H = best->p_F;
    const ThreadState& state = thread->state();
    grip.t_H = grip.X_WH.linear().transpose() *
               (state.p_W[at(best->edge) + 1] - state.p_W[at(best->edge)]).normalized();
    grip.p_H.x() = 0.0;  // the pads meet in the plane x = 0 and lay the thread into it
    if (std::abs(grip.t_H.x()) < 0.7) grip.t_H.x() = 0.0;
    grip.t_H.normalize();
    grip.slip_limit_N = 2.0 * thread_options.material.jaw_friction * n.options.jaws->hold_force_N;
    grips.add(grip, state);
    n.between_jaws.clear();
    report_on_thread(EventKind::kGrasp, index, grip.s_m);
}

void World::Impl::work_blades(int index) {
    Instrument& n = instruments[at(index)];
    if (!n.blades_set) return;
    n.between_blades.update(n.blades, thread->state(), radius_m(), true);
    const std::vector<WedgePassage> trapped = n.between_blades.trapped();
    // From the far end, so that the indices of those before stay valid.
    for (auto p = trapped.rbegin(); p != trapped.rend(); ++p) {
        if (2.0 * n.blades.half_gap_m(n.blades.from_pin_m(p->p_F)) > thread_options.diameter_m) continue;
        const ThreadState& state = thread->state();
        double t = p->t;
        if (t < kSnap) t = 0.0;
        if (t > 1.0 - kSnap) t = 1.0;
        if ((t == 0.0 && !state.has_edge(p->edge - 1)) || (t == 1.0 && !state.has_edge(p->edge + 1)))
            continue;
        const double s = t == 0.0   ? state.s_m[at(p->edge)]
                         : t == 1.0 ? state.s_m[at(p->edge) + 1]
                                    : state.s_m[at(p->edge)] + t * state.rest_length_m(p->edge);
        report_on_thread(EventKind::kCut, index, s);
        grips.forget_twist_across(s);
        thread->cut(p->edge, t);
        n.between_blades.clear();
    }
}

}  // namespace atropos::sim
