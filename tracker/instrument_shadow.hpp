#pragma once

#include <Eigen/Geometry>
#include <span>

#include "scenes/camera.hpp"
#include "scenes/capsule.hpp"
#include "tracker/image_path.hpp"
#include "tracker/ridge_points.hpp"

namespace atropos::tracker {

/// Marks what instruments cover in an eye's image, grown by `margin_px`, as hidden, and takes the ridge
/// points there away. `X_EC`: from the frame of the capsules to the eye's.
void hide_instruments(std::span<const scenes::Capsule> instruments_C, const scenes::Camera& camera,
                      const Eigen::Isometry3d& X_EC, double margin_px, RidgePointMap& map);

/// Whether something hidden lies within `reach_px` of a pixel.
bool near_hidden(const RidgePointMap& map, const Eigen::Vector2d& px, double reach_px);

/// Takes the ends of a path that lie at what is hidden on through the margin: a thread goes on to the
/// instrument.
void reach_instruments(ImagePath& path, const RidgePointMap& map, double margin_px);

}  // namespace atropos::tracker
