#include "experiments/arm_motion.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "experiments/scripted_motion.hpp"
#include "robot/manipulation.hpp"
#include "scenes/file_error.hpp"

namespace atropos::experiments {
using Eigen::Isometry3d;
namespace {

/// Sends the grip of a holder to a pose in W.
void send_grip(const MotionView& view, const Isometry3d& X_WB, const Isometry3d& X_WG) {
    const robot::CommandResult result =
        view.arm.controller().servo_cp(X_WB.inverse() * X_WG * view.arm.psm().tool().X_TG.inverse());
    if (!result) throw std::invalid_argument(view.arm.name() + ": " + result.reason);
}

/// Stands where it began, with a trembling hand.
class Holding final : public ArmMotion {
  public:
    Holding(const scenes::SceneConfig& scene, size_t arm, const MotionStart& start)
        : arm_(arm),
          X_WB_(start.X_WB),
          X_WG_(start.X_WG[arm]),
          tremor_(scene.arms.tremor_rms_m, scene.seed) {}

    void step(const MotionView& view) override {
        Isometry3d X_WG = X_WG_;
        X_WG.translation() += std::min(1.0, view.next_s) * tremor_.at(arm_, view.next_s);
        send_grip(view, X_WB_, X_WG);
    }

  private:
    size_t arm_;
    Isometry3d X_WB_, X_WG_;
    robot::Tremor tremor_;
};

/// Smooth random manipulation by both holders, defined in the camera's frame.
class Manipulating final : public ArmMotion {
  public:
    Manipulating(const scenes::SceneConfig& scene, size_t arm, const MotionStart& start)
        : arm_(arm),
          X_WB_(start.X_WB),
          X_WC_(start.X_WC),
          motion_({start.X_WC.inverse() * start.X_WG[0], start.X_WC.inverse() * start.X_WG[1]},
                  options(scene, start), scene.seed) {}

    void step(const MotionView& view) override {
        send_grip(view, X_WB_, X_WC_ * motion_.at(view.next_s)[arm_]);
    }

  private:
    static robot::ManipulationOptions options(const scenes::SceneConfig& scene, const MotionStart& start) {
        robot::ManipulationOptions options;
        options.speed_m_s = scene.arms.speed_m_s;
        options.amplitude_m = scene.arms.amplitude_m;
        options.time_scale = scene.arms.time_scale;
        options.tremor_rms_m = scene.arms.tremor_rms_m;
        options.thread_length_m = scene.thread.length_m;
        // A thread that lies in loops at the start may go on so.
        const double apart_m = (start.X_WG[1].translation() - start.X_WG[0].translation()).norm();
        options.span_min = std::min(options.span_min, 0.9 * apart_m / scene.thread.length_m);
        return options;
    }

    size_t arm_;
    Isometry3d X_WB_, X_WC_;
    robot::Manipulation motion_;
};

class Replaying final : public ArmMotion {
  public:
    Replaying(const robot::Replay& replay, double time_scale) : replay_(replay), time_scale_(time_scale) {}

    void step(const MotionView& view) override {
        const auto result = replay_.drive(view.arm.controller(), time_scale_ * view.next_s);
        if (!result) throw std::invalid_argument(view.arm.name() + ": " + result.reason);
    }

  private:
    robot::Replay replay_;
    double time_scale_;
};

class Parked final : public ArmMotion {
  public:
    void step(const MotionView&) override {}
};

}  // namespace

const scenes::ArmConfig& arm_config(const scenes::SceneConfig& scene, int arm) {
    return arm == 0 ? scene.arms.psm1 : arm == 1 ? scene.arms.psm2 : scene.arms.psm3;
}

std::unique_ptr<ArmMotion> make_arm_motion(const scenes::SceneConfig& scene, int arm,
                                           const MotionStart& start) {
    const std::string& motion = arm_config(scene, arm).motion;
    const auto index = static_cast<size_t>(arm);
    const bool holder = arm != kScissorsArm;
    if (motion == "waypoints") return make_waypoint_motion(scene, arm);
    if (motion == "replay") return std::make_unique<Replaying>(*start.replay, scene.arms.time_scale);
    if (holder && motion == "hold") return std::make_unique<Holding>(scene, index, start);
    if (holder && motion == "manipulate") return std::make_unique<Manipulating>(scene, index, start);
    if (holder && motion == "pull") return make_pull_motion(scene, arm, start);
    if (!holder && motion == "mid_grasp") return make_mid_grasp_motion(scene, start);
    if (!holder && (motion == "hold" || motion == "scissors")) return std::make_unique<Parked>();
    throw std::invalid_argument(fmt::format(
        "arms.PSM{}.motion is {}, expected one of {}", arm + 1, motion,
        holder ? "hold manipulate waypoints replay pull" : "hold scissors mid_grasp waypoints replay"));
}

robot::Replay load_replay(const scenes::SceneConfig& scene, int arm, const robot::FrameTree& tree) {
    const scenes::ArmConfig& config = arm_config(scene, arm);
    const scenes::RecordingConfig& keys = config.recording;
    const std::string name = fmt::format("PSM{}", arm + 1);
    if (keys.file.empty())
        throw std::invalid_argument("arms." + name + ".recording.file is missing, expected a recording");
    const std::filesystem::path file = keys.file;
    std::ifstream in(file);
    if (!in || std::filesystem::is_directory(file))
        throw scenes::FileError(keys.file, "can't be read, expected a recording");
    try {
        const std::vector<robot::Recording> all =
            file.extension() == ".txt" ? robot::read_jigsaws(in, keys.file)
                                       : robot::read_recording_csv(in, keys.file, keys.rate_hz);
        const std::string wanted = keys.arm.empty() ? name : keys.arm;
        const robot::Recording* recording = nullptr;
        for (const robot::Recording& r : all)
            if (r.arm == wanted || (keys.arm.empty() && all.size() == 1 && r.arm.empty())) recording = &r;
        if (!recording) throw scenes::FileError(keys.file, "no rows of " + wanted + ", expected some");
        robot::ReplayFrames frames;
        const auto imperfection = robot::Imperfection::of(scene.arms.accuracy);
        frames.X_BC = robot::registered(tree.pose("C", name + "_base"), tree.pose("C", "W").translation(),
                                        imperfection, scene.seed, name)
                          .inverse();
        frames.X_registration.translation() = keys.position_m;
        if (const double angle = keys.rotation_rad.norm(); angle > 0.0)
            frames.X_registration.linear() =
                Eigen::AngleAxisd(angle, keys.rotation_rad / angle).toRotationMatrix();
        return robot::Replay(*recording, robot::Psm(robot::tool(config.tool)), frames, keys.file);
    } catch (const scenes::FileError&) {
        throw;
    } catch (const std::runtime_error& error) {  // names file and row itself
        throw std::invalid_argument(error.what());
    }
}

}  // namespace atropos::experiments
