#pragma once

#include <Eigen/Geometry>
#include <cmath>

namespace atropos::robot {

/// One row of a modified (Craig) Denavit-Hartenberg table. Link twists of the da Vinci are quarter turns, so
/// they are stored as such and stay exact.
struct DhRow {
    int alpha_quarter_turns = 0;  ///< alpha(i-1) / (pi / 2): -1, 0 or 1
    double a_m = 0.0;             ///< a(i-1)
    double d_m = 0.0;             ///< d(i), added to a prismatic joint's value
    double theta_rad = 0.0;       ///< theta(i), added to a revolute joint's value
    bool prismatic = false;

    /// Pose of frame i in frame i-1 at joint value `q`.
    Eigen::Isometry3d pose(double q) const {
        const double theta = prismatic ? theta_rad : theta_rad + q, d = prismatic ? d_m + q : d_m;
        const double ct = std::cos(theta), st = std::sin(theta);
        const double ca = alpha_quarter_turns == 0 ? 1.0 : 0.0, sa = alpha_quarter_turns;
        Eigen::Isometry3d X;
        X.matrix() << ct, -st, 0.0, a_m,     //
            st * ca, ct * ca, -sa, -d * sa,  //
            st * sa, ct * sa, ca, d * ca,    //
            0.0, 0.0, 0.0, 1.0;
        return X;
    }
};

}  // namespace atropos::robot
