#pragma once

#include <Eigen/Geometry>

#include "scenes/polyline.hpp"

namespace atropos::sim {

/// An end of a thread as a scene gives it: where it is held and the direction in which it is held.
struct CurveEnd {
    Eigen::Vector3d p_W;
    Eigen::Vector3d tangent_W;  ///< towards increasing arc length, at both ends
};

/// A smooth curve of `length_m` from `first` to `last` that leaves both in the given directions and sags
/// along `down_W`: a first guess for `World::settle`, not an equilibrium. Throws std::invalid_argument when
/// the ends are farther apart than the length.
scenes::Polyline hanging_curve(const CurveEnd& first, const CurveEnd& last, double length_m, int points = 201,
                               const Eigen::Vector3d& down_W = -Eigen::Vector3d::UnitZ());

}  // namespace atropos::sim
