#pragma once

#include <array>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "experiments/arm_motion.hpp"
#include "render/tissue.hpp"
#include "robot/frame_tree.hpp"
#include "robot/layout.hpp"
#include "robot/robot_arm.hpp"
#include "scenes/scene_config.hpp"
#include "scenes/stereo_rig.hpp"
#include "sim/hanging_curve.hpp"
#include "sim/world.hpp"

namespace atropos::experiments {

/// What a camera could see at one instant.
struct Moment {
    double time_s = 0.0;
    std::array<std::array<Eigen::Isometry3d, robot::kLinkCount>, kArms> X_WL;
    sim::ThreadTruth thread;
};

/// The simulated operating field: arms with their imperfections, tissue, thread, stepped together at 1 kHz.
/// Built anew for each episode. It owns the truth; what a real system would know is asked of the arms
/// (`robot::Measured`).
class Testbed {
  public:
    /// Throws std::invalid_argument when the scene can't be set up (unknown tool, thread shorter than the
    /// grips' distance, grips out of reach).
    explicit Testbed(const scenes::SceneConfig& scene);
    ~Testbed();

    /// One millisecond: motions command the holding arms, all arms move, the physics follows.
    void tick();
    double time_s() const { return world_->time_s(); }

    const scenes::SceneConfig& scene() const { return scene_; }
    const scenes::StereoRig& rig() const { return rig_; }
    /// The rig as everybody but the cameras is told it: sensor.calibration_error away from the true one.
    const scenes::StereoRig& told_rig() const { return told_rig_; }
    robot::RobotArm& arm(int i) { return *arms_[static_cast<size_t>(i)]; }
    const robot::RobotArm& arm(int i) const { return *arms_[static_cast<size_t>(i)]; }

    /// Pose of the left camera: fixed during an episode.
    const Eigen::Isometry3d& X_WC() const { return X_WC_; }
    const render::Tissue* tissue() const { return tissue_ ? &*tissue_ : nullptr; }

    Eigen::Isometry3d X_WTissue() const;

    const sim::World& world() const { return *world_; }
    sim::ThreadTruth thread() const { return world_->thread(); }

    /// The field at the tick nearest to `time_s`, which is not in the future and no older than the scene's
    /// exposure and eye delay; the first tick for times before it.
    Moment moment(double time_s) const;

    /// Whether the thread's start is knotted to the tissue; else PSM1 holds it.
    bool is_knotted() const { return scene_.arms.psm1.holds == "nothing"; }

    /// Measured grip point of a holding arm in C; the end that it holds is the same as its number.
    Eigen::Vector3d measured_grip_C(int arm) const;
    /// True grip point of a holding arm in C.
    Eigen::Vector3d true_grip_C(int arm) const;

  private:
    void build_arms(const robot::Layout& layout);
    robot::Joints starting_joints(int arm, const Eigen::Isometry3d& X_WF) const;
    std::array<sim::CurveEnd, 2> starting_ends_W() const;
    scenes::Polyline starting_curve(const std::array<sim::CurveEnd, 2>& ends_W) const;
    void build_world();
    void place_instruments();
    Moment now() const;
    void remember();

    scenes::SceneConfig scene_;
    scenes::StereoRig rig_, told_rig_;
    robot::FrameTree tree_;
    Eigen::Isometry3d X_WC_ = Eigen::Isometry3d::Identity();
    std::array<std::unique_ptr<robot::RobotArm>, kArms> arms_;
    std::array<Eigen::Isometry3d, kArms> X_WB_;
    std::optional<render::Tissue> tissue_;
    std::unique_ptr<sim::World> world_;
    std::array<std::unique_ptr<ArmMotion>, kArms> motions_;
    std::deque<Moment> past_;  ///< as far back as an exposure reaches; empty when it doesn't
};

/// Where the arms' remote centres are, with the scene's instruments.
robot::Layout scene_layout(const scenes::SceneConfig& scene);

/// The calibration that everybody is told: the scene's, off by its calibration error.
scenes::StereoRig told_rig(const scenes::SceneConfig& scene);

/// The thread's options from the scene's keys: a material by name, each figure replaceable.
sim::ThreadOptions thread_options(const scenes::ThreadConfig& config);

}  // namespace atropos::experiments
