#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "scenes/camera.hpp"
#include "scenes/capsule.hpp"

namespace atropos::tracker {

/// A point of the outline under which capsules appear to an eye.
struct SilhouettePoint {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();   ///< where the viewing ray grazes, in the eye's frame (m)
    Eigen::Vector2d px = Eigen::Vector2d::Zero();  ///< its image
    Eigen::Vector2d normal = Eigen::Vector2d::UnitX();  ///< outward, unit
    Eigen::Matrix<double, 2, 3> px_per_m;               ///< d px / d p
};

/// Outline of the union of capsules (in the eye's frame), points about `step_px` apart, as far as the image
/// reaches. Outlines inside another capsule's image are left out.
std::vector<SilhouettePoint> capsule_silhouette(std::span<const scenes::Capsule> capsules,
                                                const scenes::Camera& camera, double step_px);

}  // namespace atropos::tracker
