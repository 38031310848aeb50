#include "sim/bullet_rope.hpp"

#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include "sim/bullet_units.hpp"

namespace atropos::sim {

namespace {

constexpr double kTick_s = 1e-3;  // Bullet damps by a share a step; ours is 1 ms

size_t at(int i) {
    return static_cast<size_t>(i);
}

}  // namespace

struct BulletRope::Body {
    std::unique_ptr<btSoftBody> soft;
    std::vector<double> inverse_mass;  // of the free nodes, 1/kg
};

BulletRope::BulletRope(ThreadState initial, const BulletRopeParameters& parameters,
                       btSoftRigidDynamicsWorld& world)
    : parameters_(parameters), world_(world) {
    set_state(initial);
}

BulletRope::~BulletRope() {
    if (body_) world_.removeSoftBody(body_->soft.get());
}

void BulletRope::set_state(const ThreadState& state) {
    state_ = state;
    rebuild();
}

void BulletRope::rebuild() {
    if (body_) world_.removeSoftBody(body_->soft.get());
    body_ = std::make_unique<Body>();
    const double density = parameters_.mass_kg / (state_.s_m.back() - state_.s_m.front());
    std::vector<double> mass(state_.p_W.size(), 0.0);
    for (int i = 0; i < state_.edge_count(); ++i)
        if (state_.has_edge(i))
            for (int k = 0; k < 2; ++k) mass[at(i + k)] += 0.5 * density * state_.rest_length_m(i);
    btAlignedObjectArray<btVector3> points;
    for (const auto& p : state_.p_W) points.push_back(to_bullet(p));
    world_.getWorldInfo().m_sparsesdf.Initialize();
    body_->soft = std::make_unique<btSoftBody>(&world_.getWorldInfo(), points.size(), &points[0], nullptr);
    btSoftBody& soft = *body_->soft;
    btSoftBody::Material* material = soft.appendMaterial();
    material->m_kLST = 1.0;
    for (int i = 0; i < state_.edge_count(); ++i) {
        if (!state_.has_edge(i)) continue;
        soft.appendLink(i, i + 1, material);
        btSoftBody::Link& link = soft.m_links[soft.m_links.size() - 1];
        link.m_rl = state_.rest_length_m(i) * kUnitsPerMetre;
        link.m_c1 = link.m_rl * link.m_rl;
    }
    body_->inverse_mass.resize(mass.size());
    for (int i = 0; i < state_.node_count(); ++i) {
        soft.setMass(i, mass[at(i)]);
        body_->inverse_mass[at(i)] = 1.0 / mass[at(i)];
        soft.m_nodes[i].m_v = to_bullet(state_.v_W[at(i)]);
    }
    soft.m_cfg.piterations = parameters_.iterations;
    soft.m_cfg.kDP = parameters_.air_drag_N_s_m2 / density * kTick_s + damping_;
    soft.m_cfg.kDF = 0.2;
    soft.m_cfg.collisions = btSoftBody::fCollision::SDF_RS;
    soft.getCollisionShape()->setMargin(parameters_.radius_m * kUnitsPerMetre);
    soft.setActivationState(DISABLE_DEACTIVATION);
    world_.addSoftBody(&soft);
    held_.assign(state_.p_W.size(), 0);
}

void BulletRope::cut(int edge, double t) {
    ThreadDynamics::cut(edge, t);
    rebuild();
}

void BulletRope::set_damping(double share) {
    damping_ = share;
    rebuild();
}

void BulletRope::step(double dt_s, Boundary& boundary, std::vector<SurfaceContact>&) {
    btSoftBody& soft = *body_->soft;
    for (int i = 0; i < state_.node_count(); ++i)
        if (held_[at(i)]) soft.m_nodes[i].m_im = body_->inverse_mass[at(i)];
    held_.assign(state_.p_W.size(), 0);
    for (const PrescribedNode& n : boundary.nodes) {
        btSoftBody::Node& node = soft.m_nodes[n.node];
        held_[at(n.node)] = 1;
        node.m_im = 0.0;  // a node of no inverse mass is moved by its velocity alone
        node.m_v = (to_bullet(n.p_W) - node.m_x) / dt_s;
    }
    soft.updateLinkConstants();
    world_.stepSimulation(dt_s, 0);
    for (const PrescribedNode& n : boundary.nodes) soft.m_nodes[n.node].m_x = to_bullet(n.p_W);
    for (int i = 0; i < state_.node_count(); ++i) {
        state_.p_W[at(i)] = to_metres(soft.m_nodes[i].m_x);
        state_.v_W[at(i)] = to_metres(soft.m_nodes[i].m_v);
    }
}

double BulletRope::tension_N(int edge) const {
    if (!state_.has_edge(edge)) return 0.0;
    return parameters_.EA_N *
           ((state_.p_W[at(edge) + 1] - state_.p_W[at(edge)]).norm() / state_.rest_length_m(edge) - 1.0);
}

Eigen::Vector3d BulletRope::pull_on_node_N(int node) const {
    Eigen::Vector3d pull = Eigen::Vector3d::Zero();
    for (const int edge : {node - 1, node}) {
        if (!state_.has_edge(edge)) continue;
        const Eigen::Vector3d along = (state_.p_W[at(edge) + 1] - state_.p_W[at(edge)]).normalized();
        pull += (edge == node ? 1.0 : -1.0) * tension_N(edge) * along;
    }
    return pull;
}

}  // namespace atropos::sim
