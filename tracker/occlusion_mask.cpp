#include "tracker/occlusion_mask.hpp"

namespace atropos::tracker {

bool OcclusionMask::hides(const Eigen::Vector3d& p_C) const {
    if (instruments_.empty()) return false;
    const Eigen::Vector3d ray = p_C - eye_C_;
    const Eigen::Vector3d end = eye_C_ + ray * (1.0 + behind_m_ / ray.norm());
    for (const scenes::Capsule& capsule : instruments_)
        if (scenes::segment_distance(eye_C_, end, capsule.a, capsule.b).distance_m <
            capsule.radius_m + margin_m_)
            return true;
    return false;
}

}  // namespace atropos::tracker
