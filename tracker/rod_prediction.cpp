#include "tracker/rod_prediction.hpp"

#include <Eigen/QR>

namespace atropos::tracker {
namespace {

constexpr int kNodes = 51;
constexpr double kGravity_m_s2 = 9.81;

}  // namespace

RodPrediction::RodPrediction(const CubicBasis& basis, const Eigen::Vector3d& gravity_C)
    : rod_(kNodes), gravity_m_s2_(Eigen::Vector3d::Zero()), basis_(kNodes, basis.count()) {
    if (gravity_C.norm() > 0.0) gravity_m_s2_ = kGravity_m_s2 * gravity_C.normalized();
    for (int i = 0; i < kNodes; ++i)
        basis_.row(i) = basis.basis().row(static_cast<double>(i) / (kNodes - 1)).transpose();
    // The ends are the outer control points; the others take what those leave.
    const int inner = basis.count() - 2, last = basis.count() - 1;
    fit_ = Eigen::MatrixXd::Zero(basis.count(), kNodes);
    fit_(0, 0) = fit_(last, kNodes - 1) = 1.0;
    Eigen::MatrixXd left = Eigen::MatrixXd::Identity(kNodes, kNodes);
    left.col(0) -= basis_.col(0);
    left.col(kNodes - 1) -= basis_.col(last);
    fit_.middleRows(1, inner) = basis_.middleCols(1, inner).completeOrthogonalDecomposition().solve(left);
}

void RodPrediction::correct(const Eigen::Matrix3Xd& Q, LightRod::Held held, double dt_s,
                            Eigen::Matrix3Xd& expected) const {
    const Eigen::Matrix3Xd before = Q * basis_.transpose(), carried = expected * basis_.transpose();
    Eigen::Matrix3Xd nodes = carried;
    rod_.pull(0.5 * dt_s * dt_s * gravity_m_s2_, held, nodes);
    if (rod_.keep_lengths(before, held, nodes)) expected += (nodes - carried) * fit_.transpose();
}

}  // namespace atropos::tracker
