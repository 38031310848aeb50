#include "tracker/curve_sampling.hpp"

namespace atropos::tracker {
namespace {

/// First and one past the last sample at which `column` of `weights` is not 0.
CurveSampling::Range nonzero_range(const Eigen::MatrixXd& weights, int column) {
    int first = 0;
    int last = static_cast<int>(weights.rows());
    while (first < last && weights(first, column) == 0.0) ++first;
    while (last > first && weights(last - 1, column) == 0.0) --last;
    return {first, last};
}

}  // namespace

CurveSampling::CurveSampling(int degree, int control_points, int samples)
    : table_(BasisTable::at_midpoints(BsplineBasis(degree, control_points), samples)) {
    const Eigen::MatrixXd& R = table_.value;
    const int pairs = control_points - 1;
    alpha_pair_ = R.leftCols(pairs).cwiseProduct(R.rightCols(pairs));
    for (int j = 0; j < samples; ++j) alpha_pair_.row(j) /= alpha_pair_.row(j).sum();  // eq. 18
    for (int p = 0; p < control_points; ++p) support_.push_back(nonzero_range(R, p));
    for (int p = 0; p < pairs; ++p) pair_support_.push_back(nonzero_range(alpha_pair_, p));
}

Eigen::Vector3d CurveSampling::point(std::span<const Eigen::Vector3d> control_points, int j) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int k = 0; k < this->control_points(); ++k)
        sum += R(k, j) * control_points[static_cast<std::size_t>(k)];
    return sum;
}

Eigen::Vector3d CurveSampling::velocity(std::span<const Eigen::Vector3d> control_points, int j) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int k = 0; k < this->control_points(); ++k)
        sum += dR(k, j) * control_points[static_cast<std::size_t>(k)];
    return sum;
}

}  // namespace atropos::tracker
