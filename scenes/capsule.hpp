#pragma once

#include <Eigen/Core>

namespace atropos::scenes {

/// All points within `radius_m` of the segment a-b; metres, in a frame the owner names.
struct Capsule {
    Eigen::Vector3d a = Eigen::Vector3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    double radius_m = 0.0;
};

/// Closest points of two segments p0-p1 and q0-q1, as parameters in [0, 1] and their distance.
struct SegmentDistance {
    double s;
    double t;
    double distance_m;
};
SegmentDistance segment_distance(const Eigen::Vector3d& p0, const Eigen::Vector3d& p1,
                                 const Eigen::Vector3d& q0, const Eigen::Vector3d& q1);

/// Clear distance between two capsules; negative when they overlap.
double clearance_m(const Capsule& first, const Capsule& second);

/// Clear distance from a point to a capsule's surface; negative inside.
double clearance_m(const Capsule& capsule, const Eigen::Vector3d& point);

}  // namespace atropos::scenes
