#include "tracker/curve_slide.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace atropos::tracker {
namespace {

constexpr double kSpan_m = 0.0055;     ///< longest span of a spline: 70 mm have 13
constexpr double kSpanTurn_rad = 0.4;  ///< most that a span turns by
constexpr int kFewest = 16, kMost = 40, kStep = 8;

int control_points_of(double spans) {
    int K = kFewest;
    while (K < kMost && K - 3 < spans) K += kStep;
    return K;
}

}  // namespace

CurveInterpolation::CurveInterpolation(const CubicBasis& basis) {
    const int K = basis.count();
    const std::vector<double>& knots = basis.basis().knots();
    Eigen::MatrixXd values(K, K);
    for (int k = 0; k < K; ++k) {
        const std::size_t i = static_cast<std::size_t>(k);
        greville_.push_back((knots[i + 1] + knots[i + 2] + knots[i + 3]) / 3.0);
        values.row(k) = basis.basis().row(greville_.back());
    }
    to_control_points_ = values.inverse().transpose();
}

Eigen::Matrix3Xd CurveInterpolation::carried_over(const CubicBasis& from, const Eigen::Matrix3Xd& Q,
                                                  double by_u) const {
    Eigen::Matrix3Xd values(3, static_cast<int>(greville_.size()));
    for (std::size_t k = 0; k < greville_.size(); ++k) {
        const double u = greville_[k] + by_u;
        const CubicBasisValues at = from.at(u);
        values.col(static_cast<int>(k)) = at.point(Q) + (u - std::clamp(u, 0.0, 1.0)) * at.tangent(Q);
    }
    return values * to_control_points_;
}

// Each end asks for its offset along the curve, with the information it has in that direction.
double wanted_slide_m(const std::array<std::optional<EndPrior>, 2>& ends, const Eigen::Matrix3Xd& Q) {
    const int last = static_cast<int>(Q.cols()) - 1;
    double asked = 0.0, weights = 0.0;
    for (std::size_t end = 0; end < 2; ++end) {
        if (!ends[end]) continue;
        const int k = end == 0 ? 0 : last, before = end == 0 ? 0 : last - 1;
        const Eigen::Vector3d along = (Q.col(before + 1) - Q.col(before)).normalized();
        const double weight = ends[end]->weight(Q.col(k)) * along.dot(ends[end]->information * along);
        asked += weight * along.dot(ends[end]->p_C - Q.col(k));
        weights += weight;
    }
    return weights > 0.0 ? asked / weights : 0.0;
}

int needed_control_points(double length_m) {
    return control_points_of(length_m / kSpan_m);
}

int needed_control_points(const CubicBasis& basis, const Eigen::Matrix3Xd& Q, double length_m) {
    double most_rad = 0.0;  // that the whole thread would turn by, bent as where it bends most
    for (const double u : basis.basis().distinct_knots()) {
        const CubicBasisValues at = basis.at(u);
        const Eigen::Vector3d along = at.tangent(Q);
        const double speed = std::max(along.norm(), 1e-6);
        most_rad = std::max(most_rad, along.cross(at.bend(Q)).norm() * length_m / (speed * speed * speed));
    }
    return control_points_of(std::max(length_m / kSpan_m, most_rad / kSpanTurn_rad));
}

}  // namespace atropos::tracker
