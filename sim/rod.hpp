#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/banded_ldlt.hpp"
#include "sim/rod_memory.hpp"
#include "sim/self_contact.hpp"
#include "sim/thread_dynamics.hpp"

namespace atropos::sim {

/// What a rod is made of and how it is solved; SI.
struct RodParameters {
    double EA_N = 427.0;                   ///< axial stiffness
    double EI_N_m2 = 1e-8;                 ///< bending stiffness
    double GJ_N_m2 = 0.75e-8;              ///< twisting stiffness
    double natural_curvature_per_m = 0.0;  ///< memory, see RodMemory
    double linear_density_kg_m = 6.6e-5;
    double diameter_m = 0.25e-3;
    double drag_N_s_m2 = 1e-4;  ///< air drag: force a metre of thread a m/s
    double self_friction = 0.3;
    bool self_contact = true;
    Eigen::Vector3d gravity_W_m_s2{0.0, 0.0, -9.81};
    int max_newton = 10;             ///< a step
    double tolerance_m = 1e-8;       ///< largest movement of a node in the last Newton iteration
    int max_newton_on_surface = 30;  ///< while a body is near: friction turns corners
    int max_newton_in_contact = 3;   ///< the same two while the thread touches itself
    double contact_tolerance_m = 1e-6;
    double surface_stiffness_N_m = 5e4;  ///< of one contact with a body
    double friction_speed_m_s =
        2e-5;  ///< below this a body's friction grows with speed, above it is Coulomb's
};

/// Counters of the last step, for tests and timing tables.
struct RodReport {
    int newton_iterations = 0;
    int self_contacts = 0;
    int rejected_steps = 0;      ///< halved because thread came through thread
    double min_gap_ratio = 1e9;  ///< smallest distance of touching axes over the diameter
    bool converged = true;
};

/// Implicit discrete elastic rod: nodes, one twist angle a held stretch; backward Euler in each step, found
/// as the minimum of its incremental potential by Newton's method with a banded factorisation and a line
/// search. Contact with bodies is a stiff one-sided spring with smoothed Coulomb friction inside that
/// potential; contact of the thread with itself is hard (see self_contact.hpp).
class Rod final : public ThreadDynamics {
  public:
    Rod(ThreadState initial, const RodParameters& parameters);

    void step(double dt_s, Boundary& boundary, std::vector<SurfaceContact>& contacts) override;
    void cut(int edge, double t) override;
    Eigen::Vector3d pull_on_node_N(int node) const override;
    double tension_N(int edge) const override;
    double axial_stiffness_N() const override { return parameters_.EA_N; }
    void set_state(const ThreadState& state) override;

    const RodReport& report() const { return report_; }
    RodParameters& parameters() { return parameters_; }
    const RodParameters& parameters() const { return parameters_; }

    /// Kinetic, stretching, bending, twisting and gravity energy, J.
    double energy_J(const Boundary& boundary) const;
    /// Twist of a held stretch at nodes `x`, on the branch nearest `span.twist_rad`.
    double twist_at(const TwistSpan& span, const std::vector<Eigen::Vector3d>& x) const;
    /// Its derivative by the nodes, 1/m.
    std::vector<Eigen::Vector3d> twist_gradient(const TwistSpan& span,
                                                const std::vector<Eigen::Vector3d>& x) const;
    const RodMemory& memory() const { return memory_; }
    double mass_kg() const;
    Eigen::Vector3d momentum_kg_m_s() const;

  private:
    struct Substep;
    struct Potential {
        double total_J = 0.0;
        std::vector<double> twist_rad{};  ///< of each held stretch
    };
    void set_masses();
    bool advance(Substep& sub);
    /// First guess: nodes that gather as much speed as in the last tick, where that has less potential than
    /// constant speed. Carried thread then needs one Newton iteration instead of three.
    void try_gathering_speed(Substep& sub);
    Potential potential(const Substep& sub, const std::vector<Eigen::Vector3d>& x) const;
    void assemble(Substep& sub, bool with_hessian);
    void add_surface_terms(const Substep& sub, bool with_hessian);
    void add_inertia_terms(const Substep& sub, bool with_hessian);
    void add_elastic_terms(bool with_hessian);
    void add_twist_gradient(Substep& sub);
    double elastic_energy(const std::vector<Eigen::Vector3d>& x) const;
    std::vector<double> twists(const Boundary& boundary, const std::vector<Eigen::Vector3d>& x) const;
    double twist_energy(const Boundary& boundary, const std::vector<double>& twist_rad,
                        const std::vector<Eigen::Vector3d>& x) const;
    double surface_potential(const Substep& sub, const std::vector<Eigen::Vector3d>& x) const;
    double span_length_m(const TwistSpan& span) const;
    double node_drag(size_t i) const {
        return parameters_.drag_N_s_m2 * mass_kg_[i] / parameters_.linear_density_kg_m;
    }
    void lag_friction(Substep& sub) const;
    void remember_contacts(const Substep& sub);
    void zero_where_fixed(const Substep& sub, Eigen::VectorXd& rows) const;
    /// Puts the twisting stiffness into the direction: GJ/L t t^T of each held stretch, dense but of rank one
    /// (Sherman and Morrison 1950). Stretches end in held edges, so one doesn't couple to another.
    void stiffen_by_twist(const Substep& sub);
    bool search_line(Substep& sub, double slope);
    void solve_self_contacts(Substep& sub, Eigen::VectorXd& multiplier_force);
    bool came_through_itself(const Substep& sub) const;

    RodParameters parameters_;
    RodReport report_;
    std::vector<double> mass_kg_;
    std::vector<Eigen::Vector3d> x_;  // nodes of the step in work
    std::vector<Eigen::Vector3d> trial_;
    std::vector<Eigen::Vector3d> last_v_W_;  // at the start of the last tick; empty: not known
    Eigen::VectorXd gradient_, direction_;
    BandedLdlt matrix_;
    SelfContactSolver self_contact_;
    RodMemory memory_;
    std::vector<Eigen::Vector3d> pull_N_;
    struct PastContact {
        int edge, body;
        double normal_N;
    };
    std::vector<PastContact> past_contacts_;  // of the last step, one for each of its surface contacts
};

}  // namespace atropos::sim
