#pragma once

#include <deque>
#include <string>

#include "robot/imperfection.hpp"
#include "robot/layout.hpp"

namespace atropos::robot {

/// A PSM of the scene: controller, imperfect drives, and its registration to the camera. Everything measured
/// goes through the registration; everything true through the frame tree it was built from.
class RobotArm {
  public:
    /// `tree` must hold the arm's base and C, which stay where they are.
    RobotArm(const ArmPlacement& placement, const FrameTree& tree, const Joints& q, double jaw_rad,
             const Imperfection& imperfection, std::uint64_t seed, const ArmLimits& limits = {});

    const std::string& name() const { return name_; }
    const Psm& psm() const { return controller_.psm(); }
    PsmArm& controller() { return controller_; }
    const PsmArm& controller() const { return controller_; }

    /// Advances controller and drives by one period.
    void step() {
        controller_.step();
        step_drives();
    }
    /// The second half of `step`, for who has stepped the controller.
    void step_drives();
    double time_s() const { return controller_.setpoint().time_s; }

    /// The newest measurement that has arrived by now, stamped with the time it was taken.
    const Measured<ArmState>& measured() const { return measured_; }

    /// Base in C as registered: turns poses in C into commands, X_BT = X_CB().inverse() * X_CT.
    const Eigen::Isometry3d& X_CB() const { return X_CB_; }
    /// A better registration, for instance from images.
    void set_X_CB(const Eigen::Isometry3d& X_CB) { X_CB_ = X_CB; }
    Eigen::Isometry3d command(const Eigen::Isometry3d& X_CT) const { return X_CB_.inverse() * X_CT; }

    /// What the encoders say the joints miss of the last goal, rad and m; meaningful when nothing moves.
    Measured<Joints> steady_state_error() const;

    True<ArmState> truth() const;
    /// Poses of shaft, wrist and jaws in W.
    True<std::array<Eigen::Isometry3d, kLinkCount>> true_links_W() const;
    True<std::vector<scenes::Capsule>> true_capsules_W() const;
    /// The instrument as measured, in C.
    Measured<std::vector<scenes::Capsule>> measured_capsules_C() const;

  private:
    struct Message {
        double arrival_s;
        Measured<ArmState> state;
    };
    void publish();

    std::string name_;
    Eigen::Isometry3d true_X_WB_;
    Eigen::Isometry3d true_X_CB_;
    Eigen::Isometry3d X_CB_;
    Imperfection imperfection_;
    PsmArm controller_;
    ImperfectDrive drive_;
    scenes::RandomStream delays_;
    std::int64_t steps_per_message_;
    std::deque<Message> under_way_;
    Measured<ArmState> measured_;
};

}  // namespace atropos::robot
