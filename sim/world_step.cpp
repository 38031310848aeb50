// One tick of the world: contacts, dynamics, collisions.

#include <algorithm>
#include <cmath>

#include "sim/world_impl.hpp"

namespace atropos::sim {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

constexpr double kHeldClearance_m = 3e-3;  // thread this near to a grip does not collide with its own jaws

size_t at(int i) {
    return static_cast<size_t>(i);
}

}  // namespace

bool World::Impl::hidden(const SurfaceContact& contact) const {
    const auto found = instrument_of_body.find(contact.body);
    if (found == instrument_of_body.end()) return false;
    const Instrument& instrument = instruments[at(found->second)];
    const ThreadState& state = thread->state();
    const double s = state.s_m[at(contact.edge)] + contact.t * state.rest_length_m(contact.edge);
    if (const Grip* grip = grips.of(found->second); grip && std::abs(grip->s_m - s) < kHeldClearance_m)
        return true;
    // Between jaws or blades their faces hold the thread; the capsules around them are too coarse for that.
    for (const WedgeTrap* trap : {&instrument.between_jaws, &instrument.between_blades})
        for (const WedgePassage& passage : trap->trapped())
            if (std::abs(passage.s_m - s) < kHeldClearance_m) return true;
    for (const Wedge* wedge : {&instrument.jaws, &instrument.blades}) {
        if (wedge->length_m <= 0.0) continue;
        const Vector3d p_F = wedge->X_WF.inverse() * ((1.0 - contact.t) * state.p_W[at(contact.edge)] +
                                                      contact.t * state.p_W[at(contact.edge) + 1]);
        const double r = wedge->from_pin_m(p_F);
        if (r > wedge->root_m && std::abs(p_F.y()) < wedge->half_width_m + 1e-3 &&
            std::abs(p_F.x()) < wedge->half_gap_m(std::min(r, wedge->length_m)))
            return true;
    }
    return false;
}

std::vector<SurfaceContact> World::Impl::contacts(double dt_s) const {
    std::vector<SurfaceContact> all = scene.thread_contacts(dt_s);
    std::erase_if(all, [&](const SurfaceContact& c) { return hidden(c); });
    for (SurfaceContact& c : all)
        if (c.friction < 0.0) c.friction = thread_options.material.tissue_friction;
    for (size_t i = 0; i < instruments.size(); ++i) {
        const Instrument& n = instruments[i];
        if (grips.of(static_cast<int>(i))) continue;
        n.between_jaws.add_contacts(n.jaws_before, n.jaws, thread->state(), dt_s, n.options.friction, n.body,
                                    all);
        n.between_blades.add_contacts(n.blades_before, n.blades, thread->state(), dt_s, n.options.friction,
                                      n.body, all);
    }
    return all;
}

void World::Impl::tick(double dt_s) {
    if (rope) {
        std::vector<SurfaceContact> none;
        Boundary boundary = grips.boundary(thread->state());
        scene.begin_step();
        rope->step(dt_s, boundary, none);
        scene.end_step();
        grips.measure(*thread, boundary);
        remember_wedges();
        return;
    }
    if (thread) scene.set_thread(thread->state(), radius_m());
    scene.step(dt_s, [&] {
        if (!thread) return;
        Boundary boundary = grips.boundary(thread->state());
        std::vector<SurfaceContact> found = contacts(dt_s);
        any_contact = !found.empty();
        thread->step(dt_s, boundary, found);
        grips.accept(boundary);
        grips.measure(*thread, boundary);
        note_forces(found);
    });
    remember_wedges();
}

void World::Impl::remember_wedges() {
    for (Instrument& n : instruments) {
        n.jaws_before = n.jaws;
        n.blades_before = n.blades;
    }
}

void World::step() {
    Impl& w = *impl_;
    ++w.ticks;
    w.time_s = static_cast<double>(w.ticks) * w.options.time_step_s;
    // What both faces meet in this tick is caught or cut before they push: friction goes by the normal forces
    // of the last step, so two faces that have just touched would squeeze the thread out of the wedge.
    if (w.thread)
        for (int i = 0; i < static_cast<int>(w.instruments.size()); ++i) {
            w.work_jaws(i);
            w.work_blades(i);
        }
    w.tick(w.options.time_step_s);
    if (w.thread) w.slide_grips(w.options.time_step_s);
    w.report_forces();
    w.note_collisions();
}

void World::Impl::note_forces(const std::vector<SurfaceContact>& found) {
    for (Instrument& n : instruments) n.contact_force_N = 0.0;
    for (const SurfaceContact& c : found)
        if (const auto body = instrument_of_body.find(c.body); body != instrument_of_body.end())
            instruments[at(body->second)].contact_force_N += c.normal_force_N;
}

void World::Impl::report_forces() {
    for (size_t i = 0; i < instruments.size(); ++i) {
        Instrument& n = instruments[i];
        const bool over = n.contact_force_N > options.contact_force_limit_N;
        if (over && !n.over_force_limit) {
            Event e = event(EventKind::kContactForce, static_cast<int>(i));
            e.force_N = n.contact_force_N;
            events.push_back(e);
        }
        n.over_force_limit = over;
    }
}

void World::Impl::note_collisions() {
    std::map<std::pair<int, int>, double> now;
    for (const BodyOverlap& o : scene.overlaps()) {
        const std::pair<int, int> key{o.first, o.second};
        if (now.contains(key)) continue;
        now[key] = time_s;
        if (overlapping.contains(key)) continue;
        const auto a = instrument_of_body.find(o.first), b = instrument_of_body.find(o.second);
        if (a == instrument_of_body.end() && b == instrument_of_body.end()) continue;
        const bool first = a != instrument_of_body.end();
        Event e = event(EventKind::kCollision, first ? a->second : b->second);
        e.p_W = o.p_W;
        e.other = "tissue";
        if (first && b != instrument_of_body.end()) e.other = instruments[at(b->second)].options.name;
        events.push_back(e);
    }
    overlapping = std::move(now);
}

double World::Impl::fastest_m_s() const {
    double speed = 0.0;
    for (const Vector3d& v : thread->state().v_W) speed = std::max(speed, v.norm());
    return speed;
}

}  // namespace atropos::sim
