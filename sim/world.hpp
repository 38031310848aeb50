#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scenes/polyline.hpp"
#include "scenes/triangle_mesh.hpp"
#include "sim/instrument.hpp"
#include "sim/thread_event.hpp"
#include "sim/thread_options.hpp"
#include "sim/thread_truth.hpp"

namespace atropos::sim {

struct WorldOptions {
    Eigen::Vector3d gravity_W_m_s2{0.0, 0.0, -9.81};
    double time_step_s = 1e-3;           ///< the tick; 0.1 to 5 ms
    double contact_force_limit_N = 1.0;  ///< thread against one instrument: an event above it
};

struct TissueOptions {
    std::string name = "tissue";
    /// Friction of thread on it; negative: the thread material's own figure for tissue.
    double friction = -1.0;
};

/// One episode: tissue, instruments and a thread. SI at this interface, frame W (z up). Build it anew for
/// each episode; the same calls give the same bytes. One tick is: poses are set, `step` is called.
class World {
  public:
    /// Throws std::invalid_argument for a time step outside [0.1, 5] ms.
    explicit World(const WorldOptions& options = {});
    ~World();
    World(World&&) noexcept;
    World& operator=(World&&) noexcept;

    /// A fixed surface that the thread lies on, front faces counter-clockwise.
    int add_tissue(const scenes::TriangleMesh& mesh,
                   const Eigen::Isometry3d& X_WM = Eigen::Isometry3d::Identity(),
                   const TissueOptions& options = {});

    /// Instruments have numbers 0, 1, ... in the order in which they were added.
    int add_instrument(const InstrumentOptions& options);
    /// Where the links are at the end of the coming tick, as many as the instrument has.
    void set_link_poses(int instrument, std::span<const Eigen::Isometry3d> X_WL);
    /// Grip frame and angle between the jaws at the end of the coming tick.
    void set_jaws(int instrument, const Eigen::Isometry3d& X_WG, double opening_rad);
    /// Blade frame and angle between the blades at the end of the coming tick.
    void set_blades(int instrument, const Eigen::Isometry3d& X_WS, double opening_rad);

    /// The one thread of the world, along `initial`, at rest. Throws std::logic_error when there is one
    /// already.
    void add_thread(const scenes::Polyline& initial, const ThreadOptions& options = {});
    /// Before the first tick: `instrument`, whose jaws are set, holds the thread at material arc length `s_m`
    /// in direction `tangent_G` (towards increasing s; y_G is across the jaws, z_G along them).
    void hold(int instrument, double s_m, const Eigen::Vector3d& tangent_G);
    /// Ties the thread to a fixed point; with a tangent also its direction, like a stitch.
    void anchor(double s_m, const Eigen::Vector3d& p_W,
                const std::optional<Eigen::Vector3d>& tangent_W = std::nullopt);
    /// Lets the thread come to rest under the present grips, instruments not moving; time stays. Returns the
    /// largest speed of a node at the end, m/s.
    double settle(double limit_s = 5.0);

    void step();
    double time_s() const;

    /// All events since the beginning.
    const std::vector<Event>& events() const;
    ThreadTruth thread() const;
    bool holds(int instrument) const;
    /// Material arc length at the grip; -1 when nothing is held.
    double held_s_m(int instrument) const;
    /// Force of the thread on the jaws; zero when they hold nothing.
    Eigen::Vector3d grip_force_W_N(int instrument) const;
    double grip_force_N(int instrument) const { return grip_force_W_N(instrument).norm(); }
    /// Sum of the normal forces of the thread on the instrument in the last tick, held thread not counted.
    double contact_force_N(int instrument) const;

    /// FNV-1a over all nodes' positions, velocities and arc lengths, the time and the grips.
    std::uint64_t state_hash() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace atropos::sim
