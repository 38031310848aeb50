#include "sim/world.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "sim/bullet_rope.hpp"
#include "sim/collision_scene.hpp"
#include "sim/rod.hpp"
#include "sim/thread_grips.hpp"
#include "sim/wedge.hpp"

namespace atropos::sim {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

constexpr double kHeldClearance_m = 3e-3;  // thread this near to a grip does not collide with its own jaws
constexpr double kReleaseGap = 1.5;        // diameters of room at which jaws let go
constexpr double kSnap = 0.05;             // of an edge: a cut this near to a node goes through the node
constexpr int kAnchorHolder = -1;

size_t at(int i) {
    return static_cast<size_t>(i);
}

struct Instrument {
    InstrumentOptions options;
    int body = -1;
    bool jaws_set = false, blades_set = false;
    Wedge jaws, jaws_before, blades, blades_before;
    WedgeTrap between_jaws, between_blades;
    double contact_force_N = 0.0;
    bool over_force_limit = false;
};

double linear_density_kg_m(const ThreadOptions& options) {
    return options.material.density_kg_m3 * std::numbers::pi * options.diameter_m * options.diameter_m / 4.0;
}

RodParameters rod_parameters(const ThreadOptions& options, const WorldOptions& world) {
    RodParameters p;
    const ThreadMaterial& m = options.material;
    p.EA_N = m.EA_N;
    p.EI_N_m2 = m.EI_N_m2;
    p.GJ_N_m2 = m.GJ_N_m2;
    p.linear_density_kg_m = linear_density_kg_m(options);
    p.diameter_m = options.diameter_m;
    p.drag_N_s_m2 = options.air_drag_N_s_m2;
    p.self_friction = m.self_friction;
    p.self_contact = options.self_contact;
    p.gravity_W_m_s2 = world.gravity_W_m_s2;
    p.surface_stiffness_N_m = options.surface_stiffness_N_m;
    return p;
}

BulletRopeParameters rope_parameters(const ThreadOptions& options) {
    BulletRopeParameters p;
    p.mass_kg = linear_density_kg_m(options) * options.length_m;
    p.radius_m = 0.5 * options.diameter_m;
    p.EA_N = options.material.EA_N;
    p.air_drag_N_s_m2 = options.air_drag_N_s_m2;
    p.iterations = options.soft_iterations;
    return p;
}

struct Surface {
    int body;
    TissueOptions options;
};

}  // namespace

struct World::Impl {
    WorldOptions options;
    CollisionScene scene;
    std::vector<Surface> tissues;
    std::vector<Instrument> instruments;
    std::map<int, int> instrument_of_body;
    ThreadOptions thread_options;
    std::unique_ptr<ThreadDynamics> thread;
    Rod* rod = nullptr;  // the one of these two that `thread` is
    BulletRope* rope = nullptr;
    ThreadGrips grips;
    std::vector<Event> events;
    std::map<std::pair<int, int>, double> overlapping;  // bodies that overlap, and since when
    double time_s = 0.0;
    std::int64_t ticks = 0;
    bool any_contact = false;

    explicit Impl(const WorldOptions& o) : options(o), scene(o.gravity_W_m_s2) {}

    Instrument& instrument(int i) {
        if (i < 0 || at(i) >= instruments.size())
            throw std::invalid_argument("no instrument " + std::to_string(i) + ", expected 0 to " +
                                        std::to_string(instruments.size()) + " - 1");
        return instruments[at(i)];
    }
    double radius_m() const { return 0.5 * thread_options.diameter_m; }

    Event event(EventKind kind, int instrument_index) const {
        Event e;
        e.time_s = time_s;
        e.kind = kind;
        e.instrument = instrument_index;
        if (instrument_index >= 0) e.name = instruments[at(instrument_index)].options.name;
        return e;
    }
    Vector3d point_at(double s_m) const {
        const ThreadState& state = thread->state();
        const int edge = edge_at(state, s_m);
        if (edge < 0) return s_m <= state.s_m.front() ? state.p_W.front() : state.p_W.back();
        const double t = (s_m - state.s_m[at(edge)]) / state.rest_length_m(edge);
        return (1.0 - t) * state.p_W[at(edge)] + t * state.p_W[at(edge) + 1];
    }
    void report_on_thread(EventKind kind, int who, double s_m, double force_N = 0.0) {
        Event e = event(kind, who);
        e.s_m = s_m;
        e.p_W = point_at(s_m);
        e.force_N = force_N;
        events.push_back(e);
    }

    void tick(double dt_s);
    void remember_wedges();
    double fastest_m_s() const;
    std::vector<SurfaceContact> contacts(double dt_s) const;
    bool hidden(const SurfaceContact& contact) const;
    void note_forces(const std::vector<SurfaceContact>& contacts);
    void slide_grips(double dt_s);
    void work_jaws(int index);
    void work_blades(int index);
    void note_collisions();
};

World::World(const WorldOptions& options) {
    if (!(options.time_step_s >= 1e-4 && options.time_step_s <= 5e-3))
        throw std::invalid_argument("time step is " + std::to_string(1e3 * options.time_step_s) +
                                    " ms, expected 0.1 to 5 ms");
    impl_ = std::make_unique<Impl>(options);
}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

int World::add_tissue(const scenes::TriangleMesh& mesh, const Isometry3d& X_WM,
                      const TissueOptions& options) {
    const int body = impl_->scene.add_mesh(mesh, X_WM, options.friction);
    impl_->tissues.push_back({body, options});
    return static_cast<int>(impl_->tissues.size()) - 1;
}

int World::add_instrument(const InstrumentOptions& options) {
    Instrument instrument;
    instrument.options = options;
    instrument.body = impl_->scene.add_links(options.links, options.friction);
    if (options.jaws) {
        const JawGeometry& g = *options.jaws;
        instrument.jaws.pin_to_origin_m = g.pin_to_grip_m;
        instrument.jaws.root_m = g.root_m;
        instrument.jaws.length_m = g.length_m;
        instrument.jaws.half_width_m = g.half_width_m;
    }
    if (options.blades) {
        const BladeGeometry& g = *options.blades;
        instrument.blades.pin_to_origin_m = g.pin_to_meeting_m;
        instrument.blades.root_m = g.root_m;
        instrument.blades.length_m = g.length_m;
        instrument.blades.half_width_m = g.half_thickness_m;
    }
    const int index = static_cast<int>(impl_->instruments.size());
    impl_->instrument_of_body[instrument.body] = index;
    impl_->instruments.push_back(std::move(instrument));
    return index;
}

void World::set_link_poses(int instrument, std::span<const Isometry3d> X_WL) {
    impl_->scene.set_link_poses(impl_->instrument(instrument).body, X_WL);
}

void World::set_jaws(int index, const Isometry3d& X_WG, double opening_rad) {
    Instrument& instrument = impl_->instrument(index);
    if (!instrument.options.jaws)
        throw std::logic_error("instrument " + instrument.options.name + " has no jaws");
    instrument.jaws.X_WF = X_WG;
    instrument.jaws.opening_rad = opening_rad;
    if (!instrument.jaws_set) instrument.jaws_before = instrument.jaws;
    instrument.jaws_set = true;
    impl_->grips.move(index, X_WG);
}

void World::set_blades(int index, const Isometry3d& X_WS, double opening_rad) {
    Instrument& instrument = impl_->instrument(index);
    if (!instrument.options.blades)
        throw std::logic_error("instrument " + instrument.options.name + " has no blades");
    instrument.blades.X_WF = X_WS;
    instrument.blades.opening_rad = opening_rad;
    if (!instrument.blades_set) instrument.blades_before = instrument.blades;
    instrument.blades_set = true;
}

void World::add_thread(const scenes::Polyline& initial, const ThreadOptions& options) {
    if (impl_->thread) throw std::logic_error("World::add_thread: there is a thread already");
    if (options.edges < 8 || options.edges > 2000)
        throw std::invalid_argument("thread has " + std::to_string(options.edges) +
                                    " edges, expected 8 to 2000");
    ThreadState state = state_along(initial.resampled(options.edges + 1).points);
    const double length = options.length_m > 0.0 ? options.length_m : initial.length_m();
    for (size_t i = 0; i < state.s_m.size(); ++i) state.s_m[i] = length * double(i) / options.edges;

    impl_->thread_options = options;
    impl_->thread_options.length_m = length;
    if (options.model == ThreadModel::kBulletSoft) {
        auto rope = std::make_unique<BulletRope>(std::move(state), rope_parameters(impl_->thread_options),
                                                 impl_->scene.world());
        impl_->rope = rope.get();
        impl_->thread = std::move(rope);
    } else {
        auto rod = std::make_unique<Rod>(std::move(state), rod_parameters(options, impl_->options));
        impl_->rod = rod.get();
        impl_->thread = std::move(rod);
    }
}

void World::hold(int index, double s_m, const Vector3d& tangent_G) {
    Instrument& instrument = impl_->instrument(index);
    if (!impl_->thread || !instrument.jaws_set)
        throw std::logic_error("World::hold: needs a thread and jaws that were set");
    Grip grip;
    grip.holder = index;
    grip.s_m = s_m;
    grip.X_WH = instrument.jaws.X_WF;
    grip.p_H = Vector3d::Zero();
    grip.t_H = tangent_G.normalized();
    grip.slip_limit_N =
        2.0 * impl_->thread_options.material.jaw_friction * instrument.options.jaws->hold_force_N;
    if (edge_at(impl_->thread->state(), s_m) < 0)
        throw std::invalid_argument("held arc length is " + std::to_string(1e3 * s_m) +
                                    " mm, expected one on the thread");
    impl_->grips.add(grip, impl_->thread->state());
    impl_->report_on_thread(EventKind::kGrasp, index, s_m);
}

void World::anchor(double s_m, const Vector3d& p_W, const std::optional<Vector3d>& tangent_W) {
    if (!impl_->thread) throw std::logic_error("World::anchor: needs a thread");
    if (edge_at(impl_->thread->state(), s_m) < 0)
        throw std::invalid_argument("anchored arc length is " + std::to_string(1e3 * s_m) +
                                    " mm, expected one on the thread");
    Grip grip;
    grip.holder = kAnchorHolder;
    grip.s_m = s_m;
    grip.p_H = p_W;
    grip.t_H = tangent_W ? tangent_W->normalized() : Vector3d::UnitX();
    grip.holds_direction = tangent_W.has_value();
    impl_->grips.add(grip, impl_->thread->state());
}

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
    w.note_collisions();
}

void World::Impl::note_forces(const std::vector<SurfaceContact>& found) {
    for (Instrument& n : instruments) n.contact_force_N = 0.0;
    for (const SurfaceContact& c : found)
        if (const auto body = instrument_of_body.find(c.body); body != instrument_of_body.end())
            instruments[at(body->second)].contact_force_N += c.normal_force_N;
}

void World::Impl::slide_grips(double dt_s) {
    const std::vector<int> slid = grips.slide(*thread, dt_s);
    std::vector<Grip> moved;
    for (const int g : slid) moved.push_back(grips.all()[at(g)]);
    for (const Grip& grip : moved) {
        const double pull = grips.pull_W_N(grip.holder).norm();
        // Past its strand's end the thread has slipped out of the jaws.
        const int edge = edge_at(thread->state(), grip.s_m);
        bool out = edge < 0;
        for (int i = std::min(edge, grip.strand_edge); !out && i <= std::max(edge, grip.strand_edge); ++i)
            out = !thread->state().has_edge(i);
        report_on_thread(out ? EventKind::kRelease : EventKind::kSlip, grip.holder, grip.s_m, pull);
        if (out) grips.remove(grip.holder);
    }
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

double World::settle(double limit_s) {
    Impl& w = *impl_;
    if (!w.thread) throw std::logic_error("World::settle: needs a thread");
    double spent = 0.0;
    if (w.rope) {
        w.rope->set_damping(0.02);
        for (; spent < limit_s && (spent < 0.3 || w.fastest_m_s() > 1e-4); spent += 1e-3) w.tick(1e-3);
        w.rope->set_damping(0.0);
    } else {
        const RodParameters parameters = w.rod->parameters();
        RodParameters& p = w.rod->parameters();
        p.drag_N_s_m2 = 2e-2;  // a strained first guess is let down slowly, under 0.1 m/s
        for (; spent < std::min(0.3, limit_s); spent += 1e-3) w.tick(1e-3);
        p.drag_N_s_m2 = 2e-3;  // then about critical drag, in long steps while nothing is near
        p.tolerance_m = 1e-10;
        while (spent < limit_s && w.fastest_m_s() > 1e-6) {
            const bool free = !w.any_contact && w.rod->report().self_contacts == 0;
            p.max_newton = free ? 50 : parameters.max_newton;
            const double dt = free ? 1e-2 : 1e-3;
            w.tick(dt);
            spent += dt;
        }
        p = parameters;
    }
    const double speed = w.fastest_m_s();
    ThreadState state = w.thread->state();
    for (Vector3d& v : state.v_W) v.setZero();
    w.thread->set_state(state);
    return speed;
}

double World::time_s() const {
    return impl_->time_s;
}
const std::vector<Event>& World::events() const {
    return impl_->events;
}
bool World::holds(int instrument) const {
    return impl_->grips.of(instrument) != nullptr;
}
double World::held_s_m(int instrument) const {
    const Grip* grip = impl_->grips.of(instrument);
    return grip ? grip->s_m : -1.0;
}
Vector3d World::grip_force_W_N(int instrument) const {
    return impl_->grips.pull_W_N(instrument);
}
double World::contact_force_N(int instrument) const {
    return impl_->instrument(instrument).contact_force_N;
}

ThreadTruth World::thread() const {
    if (!impl_->thread) throw std::logic_error("World::thread: there is no thread");
    const ThreadState& state = impl_->thread->state();
    ThreadTruth truth;
    truth.time_s = impl_->time_s;
    truth.radius_m = impl_->radius_m();
    truth.length_m = impl_->thread_options.length_m;
    for (int i = 0; i < state.node_count(); ++i) {
        if (i == 0 || !state.has_edge(i - 1)) truth.strands.emplace_back();
        Strand& strand = truth.strands.back();
        strand.p_W.push_back(state.p_W[at(i)]);
        strand.s_m.push_back(state.s_m[at(i)]);
        const bool before = state.has_edge(i - 1), after = state.has_edge(i);
        double tension = 0.0;
        if (before) tension += impl_->thread->tension_N(i - 1);
        if (after) tension += impl_->thread->tension_N(i);
        strand.tension_N.push_back(before && after ? 0.5 * tension : tension);
    }
    for (Strand& strand : truth.strands) strand.tangent_W = node_tangents(strand.p_W, strand.s_m);
    JudgedSpan& span = truth.span;
    span.s1_m = truth.length_m;
    const std::vector<Grip>& grips = impl_->grips.all();
    if (!grips.empty()) {
        // A lone grip judges up to the farther end of the thread.
        const Grip &first = grips.front(), &last = grips.back();
        const bool lone = grips.size() == 1, rear = lone && first.s_m > 0.5 * truth.length_m;
        if (!rear) span.s0_m = first.s_m, span.holder0 = first.holder, span.held0 = true;
        if (!lone || rear) span.s1_m = last.s_m, span.holder1 = last.holder, span.held1 = true;
    }
    span.intact = truth.strands.size() == 1 ||
                  truth.strand_at(span.s0_m) == truth.strand_at(std::nextafter(span.s1_m, 0.0));
    return truth;
}

std::uint64_t World::state_hash() const {
    std::uint64_t hash = 1469598103934665603ull;
    const auto mix = [&](double value) {
        const auto bits = std::bit_cast<std::uint64_t>(value);
        for (int k = 0; k < 8; ++k) hash = (hash ^ ((bits >> (8 * k)) & 0xff)) * 1099511628211ull;
    };
    mix(impl_->time_s);
    if (impl_->thread) {
        const ThreadState& state = impl_->thread->state();
        for (size_t i = 0; i < state.p_W.size(); ++i) {
            for (int k = 0; k < 3; ++k) mix(state.p_W[i][k]), mix(state.v_W[i][k]);
            mix(state.s_m[i]);
        }
        for (const Grip& grip : impl_->grips.all()) mix(grip.s_m), mix(grip.twist_to_next_rad);
    }
    return hash;
}

}  // namespace atropos::sim
