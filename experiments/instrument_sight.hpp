#pragma once

#include <array>
#include <optional>
#include <vector>

#include "robot/offset_filter.hpp"
#include "robot/robot_arm.hpp"
#include "robot/scissors_input.hpp"
#include "scenes/stereo_rig.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::experiments {

/// How far one arm's instrument stands from where its kinematics put it, as the images show it: looked for in
/// each frame, fused over time. Sees images and measured poses only.
class InstrumentSight {
  public:
    /// `prior_sigma_m`: RMS of the measured tip in C by the arms' calibration; 0: exact arms, nothing is
    /// looked for.
    InstrumentSight(const scenes::StereoRig& rig, scenes::ImageChannel channel, double prior_sigma_m);

    /// Looks at `arm` in `frame`, whose `instruments` are those of all arms; `others_C`: those of the other
    /// arms.
    void look(const tracker::StereoFrame& frame, const robot::RobotArm& arm,
              std::span<const scenes::Capsule> others_C);

    /// What the last frame alone showed; nothing when the instrument was not found in it.
    const std::optional<robot::InstrumentOffset>& seen() const { return seen_; }

    /// Fused over all frames so far.
    const Eigen::Vector3d& offset_C_m() const { return filter_.offset_C_m(); }

  private:
    scenes::StereoRig rig_;
    scenes::ImageChannel channel_;
    double prior_sigma_m_;
    robot::OffsetFilter filter_;
    std::optional<robot::InstrumentOffset> seen_;
    std::optional<Eigen::Vector3d> last_p_C_;
    double last_time_s_ = 0.0;
};

}  // namespace atropos::experiments
