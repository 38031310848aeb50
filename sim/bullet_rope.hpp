#pragma once

#include <memory>

#include "sim/thread_dynamics.hpp"

class btSoftRigidDynamicsWorld;

namespace atropos::sim {

struct BulletRopeParameters {
    double mass_kg = 4.6e-6;  ///< of the whole thread
    double radius_m = 0.125e-3;
    double EA_N = 427.0;  ///< only for the tension that stretch stands for; Bullet's links know no modulus
    double air_drag_N_s_m2 = 1e-4;
    int iterations = 200;
};

/// Bullet's own rope: a chain of soft-body links in Bullet's world, which steps it and sees to its contacts.
/// No bending stiffness (a bending link is a ratio), no twist, no contact with itself; stretch depends on
/// iterations and node count. A grip holds two nodes, like the rod's.
class BulletRope final : public ThreadDynamics {
  public:
    BulletRope(ThreadState initial, const BulletRopeParameters& parameters, btSoftRigidDynamicsWorld& world);
    ~BulletRope() override;

    /// Steps the whole Bullet world. `contacts` are left alone: Bullet finds its own.
    void step(double dt_s, Boundary& boundary, std::vector<SurfaceContact>& contacts) override;
    void cut(int edge, double t) override;
    Eigen::Vector3d pull_on_node_N(int node) const override;
    double tension_N(int edge) const override;
    double axial_stiffness_N() const override { return parameters_.EA_N; }
    void set_state(const ThreadState& state) override;
    /// Share of its velocity that every node loses in a step, on top of the air's.
    void set_damping(double share);

  private:
    struct Body;
    void rebuild();

    BulletRopeParameters parameters_;
    double damping_ = 0.0;
    btSoftRigidDynamicsWorld& world_;
    std::unique_ptr<Body> body_;
    std::vector<char> held_;
};

}  // namespace atropos::sim
