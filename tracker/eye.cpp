#include "tracker/eye.hpp"

#include <algorithm>

namespace atropos::tracker {

Eye::Eye(const scenes::Camera& camera, const Eigen::Isometry3d& X_EC, bool distorted)
    : camera_(camera), distorted_(distorted) {
    M_ = X_EC.linear();
    m_ = X_EC.translation();
    if (!distorted_) {
        M_ = camera.K() * M_;
        m_ = camera.K() * m_;
    }
    for (std::size_t i = 0; i < k_.size(); ++i) k_[i] = static_cast<float>(camera.distortion[i]);
    fx_ = static_cast<float>(camera.fx_px);
    fy_ = static_cast<float>(camera.fy_px);
    cx_ = static_cast<float>(camera.cx_px);
    cy_ = static_cast<float>(camera.cy_px);
}

Eigen::Vector2d Eye::pixel(const Eigen::Vector3d& homogeneous) const {
    const Eigen::Vector2d p = homogeneous.head<2>() / std::max(homogeneous.z(), kNearest);
    if (!distorted_) return p;
    const Eigen::Vector2d d = camera_.distort(p);
    return {camera_.fx_px * d.x() + camera_.cx_px, camera_.fy_px * d.y() + camera_.cy_px};
}

std::array<Eye, 2> make_eyes(const scenes::StereoRig& rig) {
    const bool distorted = rig.left.is_distorted() || rig.right.is_distorted();
    return {Eye(rig.left, Eigen::Isometry3d::Identity(), distorted), Eye(rig.right, rig.X_RC, distorted)};
}

bool rows_agree(const std::array<Eye, 2>& eyes) {
    return !eyes[0].is_distorted() && eyes[0].M().bottomRows(2) == eyes[1].M().bottomRows(2) &&
           eyes[0].m().tail(2) == eyes[1].m().tail(2);
}

}  // namespace atropos::tracker
