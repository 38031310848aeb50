#include "scenes/capsule.hpp"

#include <algorithm>

namespace atropos::scenes {

// The clamped closest-point construction of Ericson, Real-Time Collision Detection, 5.1.9.
SegmentDistance segment_distance(const Eigen::Vector3d& p0, const Eigen::Vector3d& p1,
                                 const Eigen::Vector3d& q0, const Eigen::Vector3d& q1) {
    const Eigen::Vector3d d1 = p1 - p0, d2 = q1 - q0, r = p0 - q0;
    const double a = d1.squaredNorm(), e = d2.squaredNorm(), f = d2.dot(r), c = d1.dot(r), b = d1.dot(d2);
    double s = 0.0, t = 0.0;
    if (a > 0.0 && e > 0.0) {
        const double denominator = a * e - b * b;
        s = denominator > 1e-14 * a * e ? std::clamp((b * f - c * e) / denominator, 0.0, 1.0) : 0.0;
        t = (b * s + f) / e;
        if (t < 0.0 || t > 1.0) {
            t = std::clamp(t, 0.0, 1.0);
            s = std::clamp((b * t - c) / a, 0.0, 1.0);
        }
    } else if (a > 0.0) {
        s = std::clamp(-c / a, 0.0, 1.0);
    } else if (e > 0.0) {
        t = std::clamp(f / e, 0.0, 1.0);
    }
    return {s, t, (p0 + s * d1 - q0 - t * d2).norm()};
}

double clearance_m(const Capsule& first, const Capsule& second) {
    return segment_distance(first.a, first.b, second.a, second.b).distance_m - first.radius_m -
           second.radius_m;
}

double clearance_m(const Capsule& capsule, const Eigen::Vector3d& point) {
    return segment_distance(capsule.a, capsule.b, point, point).distance_m - capsule.radius_m;
}

}  // namespace atropos::scenes
