#pragma once

#include "robot/psm_arm.hpp"
#include "robot/scissors_input.hpp"
#include "robot/scissors_options.hpp"
#include "robot/scissors_status.hpp"

namespace atropos::robot {

/// Cuts the tracked thread: a state machine that turns estimates and measured poses into commands of one
/// arm. Call step() before the arm's own step(), once every PsmArm::kPeriod_s.
class ScissorsCommand {
  public:
    /// `arm` must outlive the command and takes orders from nobody else; its joints at this moment are the
    /// parking pose. `X_CB`: its base in C as registered. Throws std::invalid_argument when the instrument
    /// has no blades or an option makes no sense.
    ScissorsCommand(const ScissorsOptions& options, PsmArm& arm, const Eigen::Isometry3d& X_CB);

    const ScissorsStatus& step(const ScissorsInput& input);
    const ScissorsStatus& status() const { return status_; }

  private:
    ScissorsOptions options_;
    PsmArm& arm_;
    Eigen::Isometry3d X_CB_;
    ScissorsStatus status_;
};

}  // namespace atropos::robot
