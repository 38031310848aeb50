#include "render/thread_body.hpp"

#include <algorithm>

#include "scenes/capsule.hpp"

namespace atropos::render {
namespace {

constexpr std::size_t kSegmentsPerBox = 16;

bool crosses(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const Eigen::Array3d inverse = (b - a).array().inverse();
    const Eigen::Array3d t0 = (box.min() - a).array() * inverse, t1 = (box.max() - a).array() * inverse;
    return std::max(t0.min(t1).maxCoeff(), 0.0) <= std::min(t0.max(t1).minCoeff(), 1.0);
}

}  // namespace

ThreadBody::ThreadBody(const ThreadRibbon& ribbon)
    : points_(ribbon.curve_W.points), radius_m_(ribbon.radius_m), arc_m_(ribbon.curve_W.arc_lengths_m()) {
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(radius_m_);
    for (std::size_t i = 0; i + 1 < points_.size(); i += kSegmentsPerBox) {
        Eigen::AlignedBox3d box;
        for (std::size_t k = i; k <= std::min(i + kSegmentsPerBox, points_.size() - 1); ++k)
            box.extend(points_[k]);
        boxes_.emplace_back(box.min() - margin, box.max() + margin);
    }
}

bool ThreadBody::blocks(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double s_low_m,
                        double s_high_m) const {
    for (std::size_t k = 0; k < boxes_.size(); ++k) {
        if (!crosses(boxes_[k], a, b)) continue;
        const std::size_t end = std::min((k + 1) * kSegmentsPerBox, points_.size() - 1);
        for (std::size_t i = k * kSegmentsPerBox; i < end; ++i) {
            if (arc_m_[i + 1] > s_low_m && arc_m_[i] < s_high_m) continue;
            if (scenes::segment_distance(a, b, points_[i], points_[i + 1]).distance_m < radius_m_)
                return true;
        }
    }
    return false;
}

}  // namespace atropos::render
