#pragma once

#include <LinearMath/btTransform.h>

#include <Eigen/Geometry>

namespace atropos::sim {

// One Bullet unit is 1 mm, because Bullet's contact margins are fixed lengths of order 0.01 and would be ten
// millimetres in SI. Mass and time keep their units. This file is the only place that converts.
static_assert(sizeof(btScalar) == sizeof(double),
              "Bullet must be the double-precision build (bullet-float64)");

inline constexpr double kUnitsPerMetre = 1000.0;

inline btVector3 to_bullet(const Eigen::Vector3d& p_m) {
    return btVector3(p_m.x(), p_m.y(), p_m.z()) * kUnitsPerMetre;
}
inline Eigen::Vector3d to_metres(const btVector3& p) {
    return Eigen::Vector3d(p.x(), p.y(), p.z()) / kUnitsPerMetre;
}
inline Eigen::Vector3d to_direction(const btVector3& n) {
    return Eigen::Vector3d(n.x(), n.y(), n.z());
}
inline btTransform to_bullet(const Eigen::Isometry3d& X) {
    const Eigen::Matrix3d R = X.linear();
    return btTransform(
        btMatrix3x3(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
        to_bullet(Eigen::Vector3d(X.translation())));
}

}  // namespace atropos::sim
