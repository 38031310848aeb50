#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "sim/thread_dynamics.hpp"

namespace atropos::sim {

/// What a thread with memory adds to a naturally straight rod: it curls about a direction of its own section,
/// so that every edge needs its own roll. Bending energy EI/2l |kb - k0 m2|^2 is that of the straight rod but
/// for the term linear in k0, which this class adds together with the twist between neighbouring edges. Rolls
/// have no inertia worth the name: they stand where the energy is least (Bergou et al. 2008, 2010).
class RodMemory {
  public:
    struct Stiffness {
        double natural_curvature_per_m = 0.0;
        double EI_N_m2 = 0.0;
        double GJ_N_m2 = 0.0;
    };

    bool is_on() const { return stiffness_.natural_curvature_per_m != 0.0; }

    /// Lays the curl into the plane in which the thread as a whole is bent.
    void reset(const ThreadState& state, const Stiffness& stiffness);
    /// After a cut on `edge`: `added` edges more before the next.
    void insert(int edge, int added);

    /// Holds the rolls of held edges to their holders, from here to the next call.
    void hold(const ThreadState& state, const std::vector<HeldRoll>& rolls);

    /// At nodes `x`, rolls at their best.
    double energy_J(const ThreadState& state, const std::vector<Eigen::Vector3d>& x) const;
    /// Its derivative by the nodes, added to `gradient`.
    void add_gradient(const ThreadState& state, const std::vector<Eigen::Vector3d>& x,
                      Eigen::VectorXd& gradient) const;
    /// Takes the rolls at `x` along to the next step.
    void accept(const ThreadState& state, const std::vector<Eigen::Vector3d>& x);

    /// Direction of the section about which edge `edge` curls.
    Eigen::Vector3d curl_axis_W(int edge) const;

  private:
    struct Frames;
    struct Roll {
        int edge;
        double angle_rad;  ///< from the holder's reference to the edge's director
        Eigen::Vector3d m_W;
    };
    struct Joint;
    Frames solved(const ThreadState& state, const std::vector<Eigen::Vector3d>& x) const;
    double energy_of(const std::vector<Joint>& joints, const std::vector<double>& roll_rad) const;
    void newton_step(const std::vector<Joint>& joints, const std::vector<char>& fixed,
                     const std::vector<double>& roll_rad, std::vector<double>& step) const;

    Stiffness stiffness_;
    std::vector<Eigen::Vector3d> director_W_,
        tangent_W_;  // of each edge; the curl is about tangent x director
    std::map<int, Roll> held_;
};

}  // namespace atropos::sim
