#pragma once

#include <string>
#include <variant>
#include <vector>

#include "robot/robot_arm.hpp"

namespace atropos::robot {

/// A sequence of motions of one arm. Poses are of a frame F fixed to the tip (grip or blade), in C.
class MotionScript {
  public:
    struct Through {
        std::vector<Eigen::Isometry3d> X_CF;
        double blend_m;
        PathLimits limits;
    };
    struct Jaw {
        double angle_rad;
        double speed_ratio;
    };
    struct Wait {
        double duration_s;
    };
    using Step = std::variant<Through, Jaw, Wait>;

    explicit MotionScript(const Eigen::Isometry3d& X_TF) : X_TF_(X_TF) {}

    /// Straight from where the arm is through these poses, corners rounded by `blend_m`, to rest at the last.
    MotionScript& through(std::vector<Eigen::Isometry3d> X_CF, double blend_m = 0.003,
                          const PathLimits& limits = {});
    MotionScript& jaw(double angle_rad, double speed_ratio = 0.1);
    MotionScript& wait(double duration_s);

    /// The same motion, `factor` times as fast in the physics' time (accelerations grow with its square).
    MotionScript faster(double factor) const;

    const std::vector<Step>& steps() const { return steps_; }
    const Eigen::Isometry3d& X_TF() const { return X_TF_; }

  private:
    Eigen::Isometry3d X_TF_;
    std::vector<Step> steps_;
};

/// Third arm to the thread: opens, goes to `approach_m` before the grip pose `X_CG` (along its z), on to it,
/// closes, and lifts by `lift_m` backwards.
MotionScript grasp_script(const Tool& tool, const Eigen::Isometry3d& X_CG, double approach_m = 0.02,
                          double lift_m = 0.005, double open_rad = 0.7);

/// Pulls a held end by `distance_m` along `direction_C`, as one of two arms that tighten a knot.
MotionScript pull_script(const Tool& tool, const Eigen::Isometry3d& X_CG, const Eigen::Vector3d& direction_C,
                         double distance_m, double speed_m_s = 0.01);

/// Runs a script on an arm: call `step` before each of the arm's own.
class ScriptRunner {
  public:
    ScriptRunner(MotionScript script, RobotArm& arm) : script_(std::move(script)), arm_(&arm) {}

    void step();
    bool is_done() const { return next_ >= script_.steps().size() && !under_way_; }
    /// Not empty: a step was refused; the arm holds and the script is over.
    const std::string& failure() const { return failure_; }

  private:
    CommandResult begin(const MotionScript::Step& step);
    bool finished(const MotionScript::Step& step) const;

    MotionScript script_;
    RobotArm* arm_;
    size_t next_ = 0;
    bool under_way_ = false;
    double wait_until_s_ = 0.0;
    std::string failure_;
};

}  // namespace atropos::robot
