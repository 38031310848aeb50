#pragma once

#include <Eigen/Core>
#include <vector>

namespace atropos::sim {

/// One piece of the thread.
struct Strand {
    std::vector<Eigen::Vector3d> p_W;        ///< nodes, m
    std::vector<double> s_m;                 ///< material arc length of the uncut thread, increasing
    std::vector<Eigen::Vector3d> tangent_W;  ///< unit, at the nodes, towards increasing s
    std::vector<double> tension_N;           ///< at the nodes; negative under thrust
};

/// The stretch between the two outermost places where the thread is held or anchored; an end that is not held
/// is the thread's own end. Its middle is at half the material length.
struct JudgedSpan {
    double s0_m = 0.0, s1_m = 0.0;
    int holder0 = -1, holder1 = -1;  ///< instrument, or -1 for an anchor or a free end
    bool held0 = false, held1 = false;
    bool intact = true;  ///< both ends on the same strand
    double middle_s_m() const { return 0.5 * (s0_m + s1_m); }
};

/// What is true of the thread at one moment. The curve that `sample` gives passes through all nodes with
/// continuous tangents; it is the one to draw and the one to judge by.
struct ThreadTruth {
    double time_s = 0.0;
    double radius_m = 0.0;
    double length_m = 0.0;
    std::vector<Strand> strands;  ///< by increasing s
    JudgedSpan span;

    /// Point of `strand` at material arc length s, clamped to the strand.
    Eigen::Vector3d sample(int strand, double s_m) const;
    /// Unit tangent of that curve, towards increasing s.
    Eigen::Vector3d tangent(int strand, double s_m) const;
    double tension_N(int strand, double s_m) const;
    /// Strand that holds material arc length s; of a cut's own s, the one before it.
    int strand_at(double s_m) const;
};

/// Tangents for `Strand` from its nodes: of the parabola through three neighbours, exact to second order for
/// any spacing.
std::vector<Eigen::Vector3d> node_tangents(const std::vector<Eigen::Vector3d>& p,
                                           const std::vector<double>& s_m);

}  // namespace atropos::sim
