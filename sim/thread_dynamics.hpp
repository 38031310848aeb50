#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace atropos::sim {

/// Nodes of all strands of one thread in the order of material arc length. Node i and i+1 are joined by an
/// edge of rest length s_m[i+1] - s_m[i] where joined[i]; where not, a strand ends at i and the next begins
/// at i+1.
struct ThreadState {
    std::vector<Eigen::Vector3d> p_W;  ///< m
    std::vector<Eigen::Vector3d> v_W;  ///< m/s
    std::vector<double> s_m;           ///< material arc length of the uncut thread
    std::vector<char> joined;          ///< one entry fewer than nodes

    int node_count() const { return static_cast<int>(p_W.size()); }
    int edge_count() const { return node_count() - 1; }
    bool has_edge(int i) const { return i >= 0 && i < edge_count() && joined[static_cast<size_t>(i)]; }
    double rest_length_m(int edge) const {
        return s_m[static_cast<size_t>(edge) + 1] - s_m[static_cast<size_t>(edge)];
    }
};

/// A node that goes where a jaw or an anchor takes it.
struct PrescribedNode {
    int node;
    Eigen::Vector3d p_W;  ///< at the end of the tick
};

/// A stretch of thread whose two end edges are held with their roll.
struct TwistSpan {
    int first_edge;
    int last_edge;
    Eigen::Vector3d m_first_W;  ///< roll references: unit, across the thread
    Eigen::Vector3d m_last_W;
    double twist_rad;  ///< in: value at the last tick, for the branch; out: value at the end of this one
};

/// A held edge whose section turns with its holder: for thread with memory, whose section is not all alike.
struct HeldRoll {
    int edge;
    int grip;             ///< which grip, as long as it lives
    Eigen::Vector3d m_W;  ///< across the thread, turns with the holder
};

/// What is imposed from outside during one tick.
struct Boundary {
    std::vector<PrescribedNode> nodes;
    std::vector<TwistSpan> twists;
    std::vector<HeldRoll> rolls{};
};

/// One point of an edge near a body's surface, seen as a plane for the length of a tick.
struct SurfaceContact {
    int edge;
    double t;                     ///< where on the edge, 0 at its first node, 1 at its second
    Eigen::Vector3d p_surface_W;  ///< point of the surface at the end of the tick
    Eigen::Vector3d normal_W;     ///< from the body to the thread
    Eigen::Vector3d v_surface_W;  ///< m/s
    double friction;
    int body;                     ///< whoever made the contact
    double normal_force_N = 0.0;  ///< out
};

/// The mechanics of a thread, whatever the model: what `ThreadGrips` and `World` need of it.
class ThreadDynamics {
  public:
    virtual ~ThreadDynamics() = default;

    const ThreadState& state() const { return state_; }

    /// Advances by `dt_s`; writes twists and contact forces back into its arguments.
    virtual void step(double dt_s, Boundary& boundary, std::vector<SurfaceContact>& contacts) = 0;

    /// Parts the thread on `edge` at fraction `t` of it; t = 0 and 1 part it on a node. Lengths, mass and
    /// momentum are kept.
    virtual void cut(int edge, double t);

    /// Force of the thread on whatever holds prescribed node `node`, at the end of the last step.
    virtual Eigen::Vector3d pull_on_node_N(int node) const = 0;

    virtual double tension_N(int edge) const = 0;
    virtual double axial_stiffness_N() const = 0;

    /// Replaces the state, e.g. by one at rest.
    virtual void set_state(const ThreadState& state) = 0;

  protected:
    ThreadState state_;
};

/// A straight-laid-out state along `points`: material arc length = the polyline's own length.
ThreadState state_along(const std::vector<Eigen::Vector3d>& points);

}  // namespace atropos::sim
