#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "robot/cartesian_path.hpp"
#include "robot/joint_servo.hpp"
#include "robot/psm.hpp"

namespace atropos::robot {

/// Limits of set-points. Velocities: dvrk_simulator_base PSM.yaml (yaw, pitch, insertion); 720 deg/s, dVRK's
/// teleop jaw rate limit (jaw, and by own choice roll and wrist, whose 50 rad/s there is no limit at all).
/// Accelerations and jerks: own choice, 4 m/s^2 and 80 m/s^3 at 0.2 m from the remote centre.
struct ArmLimits {
    std::array<MotionLimits, 6> joints = {
        MotionLimits{5.0, 20.0, 400.0}, {5.0, 20.0, 400.0},      {0.4, 4.0, 80.0},
        {12.566, 200.0, 8000.0},        {12.566, 200.0, 8000.0}, {12.566, 200.0, 8000.0}};
    MotionLimits jaw{12.566, 200.0, 8000.0};
};

/// Bounds along a Cartesian path (its parameter: see CartesianPath). Own choice: half of what scripted dVRK
/// motions show (tip median 72 mm/s).
struct PathLimits {
    double speed_m_s = 0.04;
    double acceleration_m_s2 = 0.4;
    double jerk_m_s3 = 8.0;
};

/// A command's fate. Refused commands change nothing.
struct CommandResult {
    bool accepted = true;
    std::string reason;  ///< one line when refused
    explicit operator bool() const { return accepted; }
};

/// What the controller asks of the joints.
struct Setpoint {
    double time_s = 0.0;
    Joints q = Joints::Zero();
    Joints qd = Joints::Zero();
    double jaw_rad = 0.0;
    double jaw_velocity_rad_s = 0.0;
};

/// Controller of a PSM at 1 kHz: CRTK commands in, joint set-points out. Poses are of the tip T in the base
/// B.
///  servo_*  streams: each command replaces the one before. On consecutive steps the stream's own velocity is
///           followed without lag; a jump is travelled within the limits.
///  move_*   queue in order, each from rest to rest. move_jp and move_cp go straight in joint space,
///  move_line
///           and follow straight in Cartesian space. A servo command drops the queue.
/// Goals outside joint limits or reach are refused with a reason.
class PsmArm {
  public:
    static constexpr double kPeriod_s = 1e-3;

    /// Throws std::invalid_argument when `q` or `jaw_rad` is outside the limits.
    PsmArm(const Psm& psm, const Joints& q, double jaw_rad = 0.0, const ArmLimits& limits = {});

    CommandResult servo_jp(const Joints& q);
    CommandResult servo_jr(const Joints& dq);  ///< relative to the last goal
    CommandResult servo_cp(const Eigen::Isometry3d& X_BT);
    /// Relative to the last goal: translation in B, rotation applied in B.
    CommandResult servo_cr(const Eigen::Isometry3d& X_relative);
    /// Velocity of T over angular velocity in B; goes on until the next command or the edge of the workspace.
    CommandResult servo_cv(const Twist& V_B);
    CommandResult move_jp(const Joints& q, double speed_ratio = 1.0);
    CommandResult move_jr(const Joints& dq, double speed_ratio = 1.0);
    CommandResult move_cp(const Eigen::Isometry3d& X_BT, double speed_ratio = 1.0);
    CommandResult move_line(const Eigen::Isometry3d& X_BT, const PathLimits& limits = {});
    /// A path in B that begins at the last goal (within 1 um and 1e-4 rad).
    CommandResult follow(const CartesianPath& path, const PathLimits& limits = {});
    CommandResult jaw_servo_jp(double jaw_rad);
    CommandResult jaw_move_jp(double jaw_rad, double speed_ratio = 1.0);

    /// Drops all commands and stops within the limits.
    void hold();

    /// Advances one period.
    void step();

    const Psm& psm() const { return psm_; }
    const ArmLimits& limits() const { return limits_; }
    std::int64_t steps() const { return steps_; }
    Setpoint setpoint() const;
    Eigen::Isometry3d setpoint_cp() const { return psm_.forward(setpoint().q); }
    const Joints& goal() const { return goal_; }  ///< of the last accepted command
    double jaw_goal_rad() const { return jaw_goal_rad_; }
    bool is_busy() const;      ///< a move is under way or queued
    bool is_jaw_busy() const;  ///< the jaw moves, or is not at its goal

    /// Why motion ended early (servo_cv at the edge of the workspace); empty when it did not.
    const std::string& warning() const { return warning_; }

    /// Where the joints would come to rest if told to stop now.
    Joints stopping_joints() const;

  private:
    enum class Mode { kHold, kServo, kVelocity, kMove };
    struct Move {
        Joints from;
        Joints goal;
        std::shared_ptr<const CartesianPath> path;  // null: straight in joint space
        MotionLimits along;                         // of the path's parameter, or of the share of the way
        MotionProfile profile{};
        double time_s = -1.0;  // negative: not yet begun
    };

    CommandResult start_servo(const Joints& q, Mode mode = Mode::kServo);
    CommandResult queue_move(Move move);
    void stream(const Joints& target);
    void step_move();
    void step_velocity();
    bool stands_at(const Joints& q) const;

    Psm psm_;
    ArmLimits limits_;
    std::array<JointServo, 6> joints_;
    JointServo jaw_;
    Joints goal_;
    double jaw_goal_rad_;
    Mode mode_ = Mode::kHold;
    Twist V_B_ = Twist::Zero();
    std::deque<Move> queue_;
    bool commanded_ = false;  // a servo command came since the last step
    int streamed_ = 0;        // steps in a row with a target, up to 2: how many derivatives are known
    Joints stream_target_ = Joints::Zero();
    Joints stream_velocity_ = Joints::Zero();
    std::int64_t steps_ = 0;
    std::string warning_;
};

}  // namespace atropos::robot
