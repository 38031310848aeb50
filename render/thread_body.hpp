#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "render/thread_ribbon.hpp"

namespace atropos::render {

/// A thread as capsules in boxes of sixteen, for rays.
class ThreadBody {
  public:
    explicit ThreadBody(const ThreadRibbon& ribbon);

    /// Does the segment from `a` to `b` pass within the radius of the axis anywhere outside the arc lengths
    /// (s_low, s_high)?
    bool blocks(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double s_low_m, double s_high_m) const;

    double radius_m() const { return radius_m_; }

  private:
    const std::vector<Eigen::Vector3d>& points_;
    double radius_m_;
    std::vector<double> arc_m_;
    std::vector<Eigen::AlignedBox3d> boxes_;
};

}  // namespace atropos::render
