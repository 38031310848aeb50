#include "robot/motion_filter.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace atropos::robot {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Position, velocity and fading acceleration after dt.
Matrix3d transition(double dt_s, double forget_s) {
    const double b = dt_s / forget_s, e = std::exp(-b);
    Matrix3d F = Matrix3d::Identity();
    F(0, 1) = dt_s;
    F(0, 2) = b < 1e-3 ? 0.5 * dt_s * dt_s : forget_s * forget_s * (b - 1.0 + e);
    F(1, 2) = forget_s * (1.0 - e);
    F(2, 2) = e;
    return F;
}

// Covariance of the same by white jerk of unit density; for steps well below the forgetting time.
Matrix3d jerk_noise(double t) {
    const double t2 = t * t, t3 = t2 * t;
    Matrix3d Q;
    Q << t2 * t3 / 20.0, t2 * t2 / 8.0, t3 / 6.0,  //
        t2 * t2 / 8.0, t3 / 3.0, t2 / 2.0,         //
        t3 / 6.0, t2 / 2.0, t;
    return Q;
}

}  // namespace

double MotionFilter::jerk_density() const {
    const double sigma = options_.acceleration_sigma_m_s2;
    return 2.0 * adapted_ * sigma * sigma / options_.forget_s;
}

MotionFilter::Observation MotionFilter::observation(const Vector3d& drive) {
    Observation H = Observation::Zero();
    H.leftCols<3>().setIdentity();
    for (int i = 0; i < 3; ++i) H.block<3, 3>(0, kMotion + 3 * i) = drive[i] * Matrix3d::Identity();
    return H;
}

void MotionFilter::start(double time_s, const Vector3d& p, const Matrix3d& covariance) {
    started_ = true;
    time_s_ = time_s;
    adapted_ = 1.0;
    drive_.setZero();
    belief_.x.setZero();
    belief_.x.col(0) = p;
    belief_.P.setZero();
    belief_.P.block<3, 3>(0, 0) = covariance;
    belief_.P.block<3, 3>(3, 3).diagonal().setConstant(std::pow(options_.velocity_sigma_m_s, 2));
    belief_.P.block<3, 3>(6, 6).diagonal().setConstant(std::pow(options_.acceleration_sigma_m_s2, 2));
    belief_.P.diagonal().tail<kSize - kMotion>().setConstant(std::pow(options_.response_sigma, 2));
}

MotionFilter::Belief MotionFilter::advanced(double time_s) const {
    Belief b = belief_;
    const double span = std::max(time_s - time_s_, 0.0);
    const int steps = std::clamp(static_cast<int>(std::ceil(4.0 * span / options_.forget_s)), 1, 40);
    const double dt = span / steps;
    const Matrix3d F = transition(dt, options_.forget_s), Q = jerk_density() * jerk_noise(dt);
    const double keep = std::exp(-dt / options_.response_forget_s);
    Matrix18d FF = Matrix18d::Zero();
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) FF.block<3, 3>(3 * i, 3 * j).diagonal().setConstant(F(i, j));
    FF.diagonal().tail<kSize - kMotion>().setConstant(keep);
    const double fresh = (1.0 - keep * keep) * std::pow(options_.response_sigma, 2);
    for (int step = 0; step < steps; ++step) {
        b.x.leftCols<3>() = (b.x.leftCols<3>() * F.transpose()).eval();
        b.x.rightCols<3>() *= keep;
        const Matrix18d FP = FF * b.P;
        b.P.noalias() = FP * FF.transpose();
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) b.P.block<3, 3>(3 * i, 3 * j).diagonal().array() += Q(i, j);
        b.P.diagonal().tail<kSize - kMotion>().array() += fresh;
    }
    return b;
}

double MotionFilter::surprise(double time_s, const Vector3d& p, const Matrix3d& covariance,
                              const Vector3d& drive) const {
    const Belief b = advanced(time_s);
    const Observation H = observation(drive);
    const Vector3d innovation = p - b.x.col(0) - b.x.rightCols<3>() * drive;
    return innovation.dot((H * b.P * H.transpose() + covariance).inverse() * innovation);
}

void MotionFilter::update(double time_s, const Vector3d& p, const Matrix3d& covariance,
                          const Vector3d& drive) {
    Belief b = advanced(time_s);
    const Observation H = observation(drive);
    const Matrix3d S = H * b.P * H.transpose() + covariance, S_inverse = S.inverse();
    const Vector3d innovation = p - b.x.col(0) - b.x.rightCols<3>() * drive;
    const Eigen::Matrix<double, kSize, 3> K = b.P * H.transpose() * S_inverse;
    const Eigen::Matrix<double, kSize, 1> gain = K * innovation;
    for (int i = 0; i < 6; ++i) b.x.col(i) += gain.segment<3>(3 * i);
    const Matrix18d I_KH = Matrix18d::Identity() - K * H;
    b.P = (I_KH * b.P * I_KH.transpose() + K * covariance * K.transpose()).eval();  // Joseph: stays positive
    // Innovations too large mean that the motion is livelier than thought.
    const double ratio = innovation.dot(S_inverse * innovation) / 3.0;
    adapted_ = std::clamp(adapted_ * (1.0 + 0.1 * std::clamp(ratio - 1.0, -1.0, 3.0)), options_.least_adapted,
                          options_.most_adapted);
    belief_ = b;
    time_s_ = time_s;
    drive_ = drive;
}

MotionFilter::State MotionFilter::at(double time_s, const Vector3d& drive) const {
    const double dt = std::max(time_s - time_s_, 0.0);
    const Matrix3d F = transition(dt, options_.forget_s), Q = jerk_density() * jerk_noise(dt);
    const Matrix3d x = belief_.x.leftCols<3>() * F.transpose();
    State state;
    state.R = belief_.x.rightCols<3>();
    state.p = x.col(0) + state.R * drive;
    state.v = x.col(1);
    const Observation H = observation(drive_), H_moved = observation(drive - drive_);
    state.known = H * belief_.P * H.transpose();
    state.growth = dt * dt * belief_.P.block<3, 3>(3, 3) + F(0, 2) * F(0, 2) * belief_.P.block<3, 3>(6, 6) +
                   Q(0, 0) * Matrix3d::Identity();
    if (options_.response_sigma > 0.0)
        state.growth += H_moved.rightCols<kSize - kMotion>() *
                        belief_.P.bottomRightCorner<kSize - kMotion, kSize - kMotion>() *
                        H_moved.rightCols<kSize - kMotion>().transpose();
    return state;
}

}  // namespace atropos::robot
