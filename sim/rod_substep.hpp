#pragma once

#include "sim/rod.hpp"

namespace atropos::sim {

/// One backward-Euler step of length h, the whole tick or a half, quarter, ... of it.
struct Rod::Substep {
    double h = 0.0;
    std::vector<Eigen::Vector3d> x_start;
    std::vector<Eigen::Vector3d> x_inertial;  ///< where inertia and gravity alone would lead
    std::vector<char> fixed;                  ///< nodes that go where they are told
    Boundary* boundary = nullptr;
    std::vector<SurfaceContact> contacts;  ///< planes as they stand at the end of the step
    std::vector<double> lagged_normal_N;   ///< normal forces that friction goes by in this Newton iteration
    Eigen::VectorXd multiplier_force;      ///< J^T lambda of self contact
    Potential at_x;                        ///< at the nodes as they stand in this iteration
    std::vector<std::vector<Eigen::Vector3d>> by_twist;  ///< derivative of each held stretch's twist there
};

}  // namespace atropos::sim
