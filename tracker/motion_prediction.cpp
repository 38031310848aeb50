#include "tracker/motion_prediction.hpp"

namespace atropos::tracker {
namespace {

constexpr double kVelocityDamping = 0.5;
constexpr double kFastest_m_s =
    0.15;  ///< what was farther off was found again, or has leapt: it does not go on so

}  // namespace

void MotionPrediction::predict(const Eigen::Matrix3Xd& Q, const std::array<Eigen::Vector3d, 2>& moved_m,
                               double dt_s, Eigen::Matrix3Xd& expected) const {
    expected.resize(3, Q.cols());
    for (int k = 0; k < Q.cols(); ++k) {
        const double u = static_cast<double>(k) / static_cast<double>(Q.cols() - 1);
        expected.col(k) = Q.col(k) + (1.0 - u) * moved_m[0] + u * moved_m[1] +
                          kVelocityDamping * dt_s * velocity_m_s.col(k);
    }
}

void MotionPrediction::follow(const Eigen::Matrix3Xd& found, const Eigen::Matrix3Xd& expected, double dt_s) {
    if ((found - expected).colwise().norm().maxCoeff() > kFastest_m_s * dt_s)
        velocity_m_s.setZero();
    else
        velocity_m_s = kVelocityDamping * velocity_m_s + (found - expected) / dt_s;
}

}  // namespace atropos::tracker
