#include "robot/cartesian_path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "robot/psm.hpp"

namespace atropos::robot {

CartesianPath::Step CartesianPath::step(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(from.linear().transpose() * to.linear()));
    Step s;
    s.head<3>() = to.translation() - from.translation();
    s.tail<3>() = kTurn_m * turn.angle() * turn.axis();
    return s;
}

Eigen::Isometry3d CartesianPath::moved(const Eigen::Isometry3d& from, const Step& s) {
    Eigen::Isometry3d X = from;
    X.translation() += s.head<3>();
    const Eigen::Vector3d turn = s.tail<3>() / kTurn_m;
    const double angle = turn.norm();
    if (angle > 0.0) X.linear() = from.linear() * Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
    return X;
}

// Seen from a way-point, both stretches that meet there are straight lines through zero in `Step`: a rotation
// about a fixed axis keeps its rotation vector along that axis.
CartesianPath::CartesianPath(std::vector<Eigen::Isometry3d> waypoints, double blend_m)
    : waypoints_(std::move(waypoints)) {
    const size_t n = waypoints_.size();
    if (n < 2) throw std::invalid_argument("path: fewer than two way-points");
    if (n > 2 && !(blend_m > 0.0)) throw std::invalid_argument("path: corners need a blend radius above 0");
    for (const Eigen::Isometry3d& X : waypoints_)
        if (!is_pose(X)) throw std::invalid_argument("path: a way-point is not a finite rigid pose");
    std::vector<double> lengths(n - 1);
    for (size_t i = 0; i + 1 < n; ++i) {
        const Step s = step(waypoints_[i], waypoints_[i + 1]);
        lengths[i] = s.norm();
        if (lengths[i] < 1e-9)
            throw std::invalid_argument("path: way-points " + std::to_string(i) + " and " +
                                        std::to_string(i + 1) + " are the same");
        if (s.tail<3>().norm() > kTurn_m * (std::numbers::pi - 1e-3))
            throw std::invalid_argument("path: half a turn between way-points " + std::to_string(i) +
                                        " and " + std::to_string(i + 1) + ", expected less");
    }
    double trimmed = 0.0;  // of the stretch's beginning
    for (size_t i = 0; i + 1 < n; ++i) {
        const Step leaving = step(waypoints_[i], waypoints_[i + 1]) / lengths[i];
        const bool corner = i + 2 < n;
        const double blend = corner ? std::min({blend_m, 0.5 * lengths[i], 0.5 * lengths[i + 1]}) : 0.0;
        const double straight = lengths[i] - trimmed - blend;
        pieces_.push_back({length_m_, straight, i, false, leaving, leaving, trimmed});
        length_m_ += straight;
        if (corner) {
            const Step back = step(waypoints_[i + 1], waypoints_[i]) / lengths[i];
            const Step on = step(waypoints_[i + 1], waypoints_[i + 2]) / lengths[i + 1];
            pieces_.push_back({length_m_, 2.0 * blend, i + 1, true, back, on, blend});
            length_m_ += 2.0 * blend;
        }
        trimmed = blend;
    }
}

Eigen::Isometry3d CartesianPath::at(double u_m) const {
    const double u = std::clamp(u_m, 0.0, length_m_);
    auto piece = std::upper_bound(pieces_.begin(), pieces_.end(), u,
                                  [](double value, const Piece& p) { return value < p.u_begin_m; });
    const Piece& p = *std::prev(piece);
    const Eigen::Isometry3d& X = waypoints_[p.waypoint];
    const double within = std::min(u - p.u_begin_m, p.u_length_m);
    if (!p.corner) return moved(X, (p.offset_m + within) * p.in);
    // Quintic Bezier with control points at blend times -1, -0.6, -0.2, 0.2, 0.6, 1 along the two directions:
    // no curvature where it meets the straights, and never further than 3/8 of the blend from the way-point's
    // corner.
    const double t = within / p.u_length_m, s = 1.0 - t;
    const double arriving = s * s * s * (s * s + 3.0 * s * t + 2.0 * t * t);
    const double leaving = t * t * t * (t * t + 3.0 * s * t + 2.0 * s * s);
    return moved(X, p.offset_m * (arriving * p.in + leaving * p.out));
}

}  // namespace atropos::robot
