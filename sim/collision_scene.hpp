#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "scenes/capsule.hpp"
#include "scenes/triangle_mesh.hpp"
#include "sim/thread_dynamics.hpp"

class btSoftRigidDynamicsWorld;

namespace atropos::sim {

/// Two bodies that overlap, not counting the thread.
struct BodyOverlap {
    int first, second;
    int first_link, second_link;
    Eigen::Vector3d p_W;
    double depth_m;
};

/// The Bullet world: tissue, instrument links as kinematic capsules, and one kinematic capsule an edge of
/// thread that only detects. A body is a tissue surface or a whole instrument.
class CollisionScene {
  public:
    explicit CollisionScene(const Eigen::Vector3d& gravity_W_m_s2);
    ~CollisionScene();

    int add_mesh(const scenes::TriangleMesh& mesh, const Eigen::Isometry3d& X_WM, double friction);
    int add_links(const std::vector<std::vector<scenes::Capsule>>& links, double friction);
    void set_link_poses(int body, std::span<const Eigen::Isometry3d> X_WL);

    /// One capsule an edge, wider by the distance at which contacts are announced.
    void set_thread(const ThreadState& state, double radius_m);

    /// One tick of the Bullet world; `advance` is called when the contacts of this tick are known.
    void step(double dt_s, const std::function<void()>& advance);

    /// The same in two halves, for a thread that Bullet itself steps in between.
    void begin_step();
    void end_step();

    /// Contacts of the thread in this tick, in a fixed order. Normals point to the thread.
    std::vector<SurfaceContact> thread_contacts(double dt_s) const;
    std::vector<BodyOverlap> overlaps() const;

    btSoftRigidDynamicsWorld& world();

    static constexpr double kAnnounced_m =
        0.25e-3;  ///< contacts are found this far ahead: 250 mm/s in a tick

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace atropos::sim
