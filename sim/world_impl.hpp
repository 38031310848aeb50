#pragma once

#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/bullet_rope.hpp"
#include "sim/collision_scene.hpp"
#include "sim/rod.hpp"
#include "sim/thread_grips.hpp"
#include "sim/wedge.hpp"
#include "sim/world.hpp"

namespace atropos::sim {

/// An instrument as it stands in the world.
struct Instrument {
    InstrumentOptions options;
    int body = -1;
    bool jaws_set = false, blades_set = false;
    Wedge jaws, jaws_before, blades, blades_before;
    WedgeTrap between_jaws, between_blades;
    double contact_force_N = 0.0;
    bool over_force_limit = false;
};

struct Surface {
    int body;
    TissueOptions options;
};

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
        if (i < 0 || static_cast<size_t>(i) >= instruments.size())
            throw std::invalid_argument("no instrument " + std::to_string(i) + ", expected 0 to " +
                                        std::to_string(instruments.size()) + " - 1");
        return instruments[static_cast<size_t>(i)];
    }
    double radius_m() const { return 0.5 * thread_options.diameter_m; }

    Event event(EventKind kind, int instrument_index) const {
        Event e;
        e.time_s = time_s;
        e.kind = kind;
        e.instrument = instrument_index;
        if (instrument_index >= 0) e.name = instruments[static_cast<size_t>(instrument_index)].options.name;
        return e;
    }
    Eigen::Vector3d point_at(double s_m) const {
        const ThreadState& state = thread->state();
        const int edge = edge_at(state, s_m);
        if (edge < 0) return s_m <= state.s_m.front() ? state.p_W.front() : state.p_W.back();
        const double t = (s_m - state.s_m[static_cast<size_t>(edge)]) / state.rest_length_m(edge);
        return (1.0 - t) * state.p_W[static_cast<size_t>(edge)] +
               t * state.p_W[static_cast<size_t>(edge) + 1];
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
    void report_forces();
    void slide_grips(double dt_s);
    void work_jaws(int index);
    void work_blades(int index);
    void note_collisions();
};

}  // namespace atropos::sim
