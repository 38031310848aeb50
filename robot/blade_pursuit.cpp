#include "robot/blade_pursuit.hpp"

#include <algorithm>
#include <cmath>

#include "robot/psm_arm.hpp"

namespace atropos::robot {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kRamp_s = 0.2;  // from rest to full speed; jerk is such that ramps are half smooth
constexpr double kTurnMemory_s = 0.1;

MotionLimits limits_for(double speed) {
    return {speed, 2.0 * speed / kRamp_s, 8.0 * speed / (kRamp_s * kRamp_s)};
}

}  // namespace

BladeTravel::BladeTravel(const Isometry3d& X_CS, const Vector3d& target_C, double standoff_m)
    : R_start_(X_CS.linear()), gap_(X_CS.translation() - target_C + standoff_m * X_CS.linear().col(2)) {}

Isometry3d BladeTravel::at(double share, const Vector3d& target_C, const Matrix3d& R_CS,
                           double standoff_m) const {
    Isometry3d X = Isometry3d::Identity();
    X.linear() = Quaterniond(R_CS).slerp(share, R_start_).toRotationMatrix();
    X.translation() = target_C + share * gap_ - standoff_m * X.linear().col(2);
    return X;
}

double BladeTravel::turn_rad(const Matrix3d& R_CS) const {
    return R_start_.angularDistance(Quaterniond(R_CS));
}

double BladeTravel::way_m(const Matrix3d& R_CS, double standoff_m) const {
    return gap_.norm() + standoff_m * turn_rad(R_CS);
}

void BladePursuit::Glide::to(double position, const MotionLimits& limits) {
    goal = position;
    profile = MotionProfile::to_rest_at(state, position, limits);
    time_s = 0.0;
}

void BladePursuit::Glide::step() {
    time_s += PsmArm::kPeriod_s;
    state = done() ? MotionState{goal, 0.0, 0.0} : profile.at(time_s);
}

BladePursuit::BladePursuit(const Options& options, const Isometry3d& X_CS)
    : options_(options), X_CS_(X_CS), limited_(X_CS.linear()), smooth_(X_CS.linear()) {}

void BladePursuit::travel(const Goal& goal, double standoff_m) {
    travel_ = BladeTravel(X_CS_, goal.p_C, standoff_m);
    error_.setZero();
    error_rate_.setZero();
    limited_ = smooth_ = Quaterniond(goal.R_CS);
    const double way = std::max(travel_.way_m(goal.R_CS, standoff_m), 1e-6);
    const double turn = std::max(travel_.turn_rad(goal.R_CS), 1e-6);
    share_.state = {1.0, 0.0, 0.0};
    share_.to(0.0, limits_for(std::min(options_.travel_speed_m_s / way, options_.turn_speed_rad_s / turn)));
    standoff_ = {};
    standoff_.state.position = standoff_m;
    standoff_.to(standoff_m, limits_for(options_.near_speed_m_s));
}

void BladePursuit::advance_to(double standoff_m) {
    standoff_.to(standoff_m, limits_for(options_.near_speed_m_s));
}

void BladePursuit::absorb(const Vector3d& p, const Vector3d& v) {
    error_ += p;
    error_rate_ += v;
}

BladePursuit::Goal BladePursuit::stand(const Isometry3d& X_CS, const Vector3d& v) {
    X_CS_ = X_CS;
    share_ = {};
    error_.setZero();
    error_rate_ = v;
    limited_ = smooth_ = Quaterniond(X_CS.linear());
    return {X_CS.translation() + standoff_.state.position * X_CS.linear().col(2), X_CS.linear()};
}

void BladePursuit::yield(const Vector3d& p_C) {
    error_ += p_C - X_CS_.translation();
    error_rate_.setZero();
}

void BladePursuit::turn_towards(const Matrix3d& R_CS) {
    const double dt = PsmArm::kPeriod_s;
    const Quaterniond wanted(R_CS);
    const double angle = limited_.angularDistance(wanted);
    if (angle > 0.0)
        limited_ = limited_.slerp(std::min(1.0, options_.turn_speed_rad_s * dt / angle), wanted).normalized();
    smooth_ = smooth_.slerp(dt / kTurnMemory_s, limited_).normalized();
}

const Isometry3d& BladePursuit::step(const Goal& goal) {
    const double dt = PsmArm::kPeriod_s, tau = options_.smooth_s;
    share_.step();
    standoff_.step();
    turn_towards(goal.R_CS);
    // What was absorbed fades without a jump in position or velocity: critically damped where it is small, at
    // a bounded speed where it is large.
    Vector3d wanted = -error_ / tau;
    if (wanted.norm() > options_.correction_speed_m_s)
        wanted *= options_.correction_speed_m_s / wanted.norm();
    error_rate_ += dt * 4.0 / tau * (wanted - error_rate_);
    error_ += dt * error_rate_;
    X_CS_ = travel_.at(share_.state.position, goal.p_C + error_, smooth_.toRotationMatrix(),
                       standoff_.state.position);
    return X_CS_;
}

}  // namespace atropos::robot
