#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "sim/thread_dynamics.hpp"

namespace atropos::sim {

/// A place where the thread is held: by jaws, or anchored in tissue (holder -1). It holds position, direction
/// and roll; without a direction, position alone.
struct Grip {
    int holder = -1;
    int number = 0;                                  ///< unlike that of all grips before
    int strand_edge = 0;                             ///< edge that is held, kept up to date by `ThreadGrips`
    double s_m = 0.0;                                ///< material arc length at the holder's point
    Eigen::Vector3d p_H = Eigen::Vector3d::Zero();   ///< that point in the holder's frame,
    Eigen::Vector3d t_H = Eigen::Vector3d::UnitX();  ///< the thread's tangent there,
    Eigen::Vector3d m_H = Eigen::Vector3d::UnitY();  ///< and its roll reference
    bool holds_direction = true;
    Eigen::Isometry3d X_WH = Eigen::Isometry3d::Identity();
    double slip_limit_N = 1e9;
    bool slipping = false;  ///< then the limit is `kSlidingShare` of that
    double twist_to_next_rad = 0.0;
};

/// A grip through which thread slid.
struct SlidGrip {
    const Grip* grip;
    bool begins;  ///< it held in the tick before
};

/// All grips of one thread, by increasing arc length, and the boundary conditions they make.
class ThreadGrips {
  public:
    const std::vector<Grip>& all() const { return grips_; }
    const Grip* of(int holder) const;
    bool empty() const { return grips_.empty(); }

    /// Adds a grip at its arc length; its roll reference is set so that the thread's twist does not change.
    void add(Grip grip, const ThreadState& state);
    /// Removes a holder's grip; the twist of both sides runs together.
    void remove(int holder);
    /// Moves the frames of a holder's grip.
    void move(int holder, const Eigen::Isometry3d& X_WH);

    /// Prescribed nodes and twists for the next tick.
    Boundary boundary(const ThreadState& state);
    /// Keeps the twists that a step has found.
    void accept(const Boundary& boundary);

    /// Friction of sliding over that of rest; own choice, 0.7 to 0.9 is usual on steel. It is why of two jaws
    /// that pull on one another only one lets the thread through: once it slides it gives way first.
    static constexpr double kSlidingShare = 0.8;

    /// Lets thread slide through the grip whose pull is farthest beyond its limit, if there is one: moves its
    /// `s_m`. The grip lives until the next call that changes grips.
    std::optional<SlidGrip> slide(const ThreadDynamics& thread, double dt_s);
    Eigen::Vector3d pull_W_N(int holder) const;
    void measure(const ThreadDynamics& thread, const Boundary& boundary);

    /// After a cut: nothing is twisted across it.
    void forget_twist_across(double s_m);

  private:
    struct Held {
        std::vector<int> nodes;
    };
    int next_number_ = 0;
    std::vector<Grip> grips_;
    std::vector<Held> held_;
    std::vector<Eigen::Vector3d> pull_N_;
    std::vector<int> span_of_;  // twist k of the boundary starts at grip span_of_[k]
};

/// Edge that carries material arc length `s_m`; of a cut's own, the one before it; -1 beyond the ends.
int edge_at(const ThreadState& state, double s_m);

}  // namespace atropos::sim
