#pragma once

#include <array>
#include <memory>
#include <string>

#include "experiments/arm_reading.hpp"
#include "robot/frame_tree.hpp"
#include "robot/recording.hpp"
#include "robot/robot_arm.hpp"
#include "scenes/scene_config.hpp"
#include "sim/world.hpp"

namespace atropos::experiments {

/// The key section of arm 0, 1 or 2.
const scenes::ArmConfig& arm_config(const scenes::SceneConfig& scene, int arm);

/// What a motion may look at: it plays the surgeon, who sees thread and instruments as they are.
struct MotionView {
    double next_s;  ///< end of the coming period
    robot::RobotArm& arm;
    const sim::World& world;
};

/// What drives one arm of a scene; the scissors command drives its arm itself.
class ArmMotion {
  public:
    virtual ~ArmMotion() = default;

    /// Commands the arm for the coming period. Throws std::invalid_argument when a command is refused.
    virtual void step(const MotionView& view) = 0;
};

/// What a motion begins with.
struct MotionStart {
    std::array<Eigen::Isometry3d, 2> X_WG;  ///< grip frames of both holders
    Eigen::Isometry3d X_WC, X_WB;           ///< camera, and the arm's own base
    const robot::Replay* replay = nullptr;  ///< motion: replay
};

/// The motion that the scene's keys ask of an arm. Throws std::invalid_argument when they don't suit it.
std::unique_ptr<ArmMotion> make_arm_motion(const scenes::SceneConfig& scene, int arm,
                                           const MotionStart& start);

/// The recording of an arm whose motion is replay. Throws FileError with the first offending row.
robot::Replay load_replay(const scenes::SceneConfig& scene, int arm, const robot::FrameTree& tree);

}  // namespace atropos::experiments
