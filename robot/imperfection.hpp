#pragma once

#include <cstdint>
#include <string_view>

#include "robot/arm_state.hpp"
#include "robot/psm_arm.hpp"
#include "scenes/random_stream.hpp"
#include "scenes/scene_config.hpp"

namespace atropos::robot {

/// How an arm differs from what it believes. Set-point -> (lag, stiction) -> encoder -> (offset, play) ->
/// joint. Standard deviations are of one axis; drawn once a run but for the encoders' noise.
struct Imperfection {
    Eigen::Vector3d offset_sigma = Eigen::Vector3d::Zero();  ///< yaw, pitch (rad), insertion (m)
    Eigen::Vector3d play =
        Eigen::Vector3d::Zero();               ///< half width (rad) of roll, wrist pitch, wrist yaw cables
    Joints stiction = Joints::Zero();          ///< half width of the set-point's play (rad, m)
    double lag_s = 0.0;                        ///< time constant of the joints behind their set-points
    Joints encoder_sigma = Joints::Zero();     ///< rad, m
    double hand_eye_position_sigma_m = 0.0;    ///< of the arm's registration, at the working point
    double hand_eye_rotation_sigma_rad = 0.0;  ///< about the working point
    double publish_period_s = PsmArm::kPeriod_s;
    double latency_s = 0.0;  ///< from measurement to its arrival
    double jitter_s = 0.0;   ///< greatest further delay, uniform

    /// kPerfect: nothing. kCalibrated: tip in C off by 1.9 mm RMS, hand-eye 1.0 of it, the rest mostly wrist
    /// cables. kUncalibrated: 4 mm. kAsRecorded: joint errors RMS 0.09 deg, 0.08 deg, 0.39
    /// mm, 9.5, 10.9, 15.1 deg as measured on a dVRK (Berkeley's peg transfer), without hand-eye error.
    static Imperfection of(scenes::ArmAccuracy accuracy);
};

/// Gear with play: the output stands until the input has crossed the gap, then is dragged along.
class Play {
  public:
    Play() = default;
    Play(double half_width, double output) : half_width_(half_width), output_(output) {}
    double follow(double input);
    double output() const { return output_; }

  private:
    double half_width_ = 0.0;
    double output_ = 0.0;
};

/// Drives and cables of one arm: turns set-points into what the encoders see and where the joints truly are.
class ImperfectDrive {
  public:
    ImperfectDrive(const Imperfection& imperfection, std::uint64_t seed, std::string_view arm,
                   const Setpoint& start);

    /// Advances one period.
    void step(const Setpoint& setpoint);

    True<Joints> true_joints() const { return {true_q_}; }
    double jaw_rad() const { return jaw_rad_; }

    /// Encoder readings without and with their noise; `read` draws from the arm's stream.
    const Joints& encoders() const { return encoder_q_; }
    Measured<Joints> read();

  private:
    Imperfection imperfection_;
    scenes::RandomStream noise_;
    double follow_ratio_;
    Joints lagging_q_;
    std::array<Play, 6> stiction_;
    std::array<Play, 3> cables_;
    Eigen::Vector3d offset_;
    Joints encoder_q_;
    Joints true_q_;
    double jaw_rad_;
};

/// A registration of `X_CB` with the error of this run: turned and shifted about the working point `p_CW`.
Eigen::Isometry3d registered(const Eigen::Isometry3d& X_CB, const Eigen::Vector3d& p_CW,
                             const Imperfection& imperfection, std::uint64_t seed, std::string_view arm);

}  // namespace atropos::robot
