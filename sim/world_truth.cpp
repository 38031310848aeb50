// What is true of the world at this moment.

#include <bit>
#include <cmath>

#include "sim/world_impl.hpp"

namespace atropos::sim {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

size_t at(int i) {
    return static_cast<size_t>(i);
}

}  // namespace

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
