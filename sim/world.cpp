#include "sim/world.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/world_impl.hpp"

namespace atropos::sim {

using Eigen::Isometry3d;
using Eigen::Vector3d;
namespace {

constexpr int kAnchorHolder = -1;

double linear_density_kg_m(const ThreadOptions& options) {
    return options.material.density_kg_m3 * std::numbers::pi * options.diameter_m * options.diameter_m / 4.0;
}

RodParameters rod_parameters(const ThreadOptions& options, const WorldOptions& world) {
    RodParameters p;
    const ThreadMaterial& m = options.material;
    p.EA_N = m.EA_N;
    p.EI_N_m2 = m.EI_N_m2;
    p.GJ_N_m2 = m.GJ_N_m2;
    p.natural_curvature_per_m = options.natural_curvature_per_m;
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

}  // namespace

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

}  // namespace atropos::sim
