#include "robot/imperfection.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace atropos::robot {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::string stream_name(std::string_view arm, const char* what) {
    return "arm." + std::string(arm) + "." + what;
}

}  // namespace

Imperfection Imperfection::of(scenes::ArmAccuracy accuracy) {
    Imperfection i;
    if (accuracy == scenes::ArmAccuracy::kPerfect) return i;
    // Set-point to encoder: mean 0.32, max 0.63 mm on a moving dVRK; topics at 100 Hz, under 1 ms on the way.
    i.stiction << 0.02 * kDegree, 0.02 * kDegree, 0.1e-3, 0.2 * kDegree, 0.2 * kDegree, 0.2 * kDegree;
    i.lag_s = 0.008;
    i.encoder_sigma << 2e-5, 2e-5, 1e-5, 1e-4, 1e-4, 1e-4;  // own choice
    i.publish_period_s = 0.010;
    i.latency_s = 0.001;
    i.jitter_s = 0.001;
    switch (accuracy) {
        case scenes::ArmAccuracy::kPerfect:
            break;
        case scenes::ArmAccuracy::kCalibrated:
            i.offset_sigma << 0.1 * kDegree, 0.1 * kDegree, 0.4e-3;
            i.play = Eigen::Vector3d(8.5, 9.7, 9.7) * kDegree;
            i.hand_eye_position_sigma_m = 1.0e-3 / std::numbers::sqrt3;
            i.hand_eye_rotation_sigma_rad = 0.3 * kDegree;
            break;
        case scenes::ArmAccuracy::kUncalibrated:
            i.offset_sigma << 0.45 * kDegree, 0.45 * kDegree, 2.0e-3;
            i.play = Eigen::Vector3d(8.5, 9.7, 9.7) * kDegree;
            i.hand_eye_position_sigma_m = 2.1e-3 / std::numbers::sqrt3;
            i.hand_eye_rotation_sigma_rad = 1.0 * kDegree;
            break;
        case scenes::ArmAccuracy::kAsRecorded:
            i.offset_sigma << 0.09 * kDegree, 0.08 * kDegree, 0.39e-3;
            i.play = Eigen::Vector3d(10.4, 12.1, 17.3) * kDegree;
            break;
    }
    return i;
}

double Play::follow(double input) {
    output_ = std::clamp(output_, input - half_width_, input + half_width_);
    return output_;
}

ImperfectDrive::ImperfectDrive(const Imperfection& imperfection, std::uint64_t seed, std::string_view arm,
                               const Setpoint& start)
    : imperfection_(imperfection),
      noise_(seed, stream_name(arm, "encoders")),
      follow_ratio_(imperfection.lag_s > 0.0 ? 1.0 - std::exp(-PsmArm::kPeriod_s / imperfection.lag_s) : 1.0),
      lagging_q_(start.q),
      encoder_q_(start.q),
      true_q_(start.q),
      jaw_rad_(start.jaw_rad) {
    scenes::RandomStream random(seed, stream_name(arm, "joints"));
    for (int i = 0; i < 6; ++i)
        stiction_[static_cast<size_t>(i)] = Play(imperfection.stiction[i], start.q[i]);
    for (int i = 0; i < 3; ++i) offset_[i] = random.normal(0.0, imperfection.offset_sigma[i]);
    for (int i = 0; i < 3; ++i) {  // cables rest anywhere within their play
        const double rest = random.uniform(-1.0, 1.0) * imperfection.play[i];
        cables_[static_cast<size_t>(i)] = Play(imperfection.play[i], start.q[3 + i] + rest);
    }
    step(start);
}

void ImperfectDrive::step(const Setpoint& setpoint) {
    lagging_q_ += follow_ratio_ * (setpoint.q - lagging_q_);
    jaw_rad_ += follow_ratio_ * (setpoint.jaw_rad - jaw_rad_);
    for (int i = 0; i < 6; ++i) encoder_q_[i] = stiction_[static_cast<size_t>(i)].follow(lagging_q_[i]);
    true_q_.head<3>() = encoder_q_.head<3>() + offset_;
    for (int i = 0; i < 3; ++i) true_q_[3 + i] = cables_[static_cast<size_t>(i)].follow(encoder_q_[3 + i]);
}

Measured<Joints> ImperfectDrive::read() {
    Joints q = encoder_q_;
    for (int i = 0; i < 6; ++i) q[i] += imperfection_.encoder_sigma[i] * noise_.normal();
    return {q};
}

Eigen::Isometry3d registered(const Eigen::Isometry3d& X_CB, const Eigen::Vector3d& p_CW,
                             const Imperfection& imperfection, std::uint64_t seed, std::string_view arm) {
    scenes::RandomStream random(seed, stream_name(arm, "hand_eye"));
    Eigen::Vector3d shift, turn;
    for (int i = 0; i < 3; ++i) shift[i] = random.normal(0.0, imperfection.hand_eye_position_sigma_m);
    for (int i = 0; i < 3; ++i) turn[i] = random.normal(0.0, imperfection.hand_eye_rotation_sigma_rad);
    const double angle = turn.norm();
    if (angle == 0.0 && shift.isZero(0.0)) return X_CB;  // perfect means the same bits
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translate(p_CW + shift);
    if (angle > 0.0) X.rotate(Eigen::AngleAxisd(angle, turn / angle));
    X.translate(-p_CW);
    return X * X_CB;
}

}  // namespace atropos::robot
