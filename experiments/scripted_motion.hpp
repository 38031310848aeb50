#pragma once

#include "experiments/arm_motion.hpp"

namespace atropos::experiments {

/// Through the scene's way-points, from where the arm starts, corners rounded.
std::unique_ptr<ArmMotion> make_waypoint_motion(const scenes::SceneConfig& scene, int arm);

/// A holder pulls away from the other one until the thread pulls back as asked.
std::unique_ptr<ArmMotion> make_pull_motion(const scenes::SceneConfig& scene, int arm,
                                            const MotionStart& start);

/// The third arm takes the thread between the grips, lifts it, and carries it through its way-points, if any.
std::unique_ptr<ArmMotion> make_mid_grasp_motion(const scenes::SceneConfig& scene, const MotionStart& start);

}  // namespace atropos::experiments
