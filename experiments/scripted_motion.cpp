#include "experiments/scripted_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "robot/layout_defaults.hpp"
#include "robot/motion_script.hpp"

namespace atropos::experiments {
using Eigen::Isometry3d;
using Eigen::Vector3d;
namespace {

constexpr double kApproach_m = 0.010, kRamp_s = 0.2;

/// Runs one script on the arm; built when it begins, because it starts from where the arm then is.
class Scripted {
  public:
    bool is_under_way() const { return runner_.has_value(); }
    bool is_done() const { return runner_ && runner_->is_done(); }
    void begin(const robot::MotionScript& script, robot::RobotArm& arm, double time_scale) {
        runner_.emplace(script.faster(time_scale), arm);
    }
    void step(const robot::RobotArm& arm) {
        if (!runner_) return;
        runner_->step();
        if (!runner_->failure().empty()) throw std::invalid_argument(arm.name() + ": " + runner_->failure());
    }

  private:
    std::optional<robot::ScriptRunner> runner_;
};

/// The frame that tells where the instrument works: of jaws that hold, of blades.
Isometry3d working_frame(const robot::Tool& tool) {
    return tool.kind == robot::ToolKind::kScissors && tool.X_TS ? *tool.X_TS : tool.X_TG;
}

/// Where the arm is told to be, in C as it is registered.
Isometry3d believed(const robot::RobotArm& arm, const Isometry3d& X_TF) {
    return arm.X_CB() * arm.psm().forward(arm.controller().goal()) * X_TF;
}

/// Through way-points from where the arm is.
robot::MotionScript waypoint_script(const scenes::WaypointConfig& keys, const robot::RobotArm& arm) {
    const Isometry3d X_TF = working_frame(arm.psm().tool()), X_CF = believed(arm, X_TF);
    std::vector<Isometry3d> way;
    for (size_t i = 0; i < keys.offsets_m.size(); ++i) {
        way.push_back(X_CF);
        way.back().translation() += keys.offsets_m[i];
        const Vector3d turn = keys.turns_rad.empty() ? Vector3d::Zero() : keys.turns_rad[i];
        if (const double angle = turn.norm(); angle > 0.0)
            way.back().linear() = Eigen::AngleAxisd(angle, turn / angle) * X_CF.linear();
    }
    robot::MotionScript script(X_TF);
    const double v = keys.speed_m_s;
    return script.through(std::move(way), keys.blend_m, {v, 10.0 * v, 200.0 * v});
}

void check_waypoints(const scenes::WaypointConfig& keys, int arm) {
    if (!keys.turns_rad.empty() && keys.turns_rad.size() != keys.offsets_m.size())
        throw std::invalid_argument(
            fmt::format("arms.PSM{}.waypoints.turns_deg has {} rows, expected {} like offsets_mm", arm + 1,
                        keys.turns_rad.size(), keys.offsets_m.size()));
}

class Waypoints final : public ArmMotion {
  public:
    Waypoints(const scenes::WaypointConfig& keys, double time_scale) : keys_(keys), time_scale_(time_scale) {}

    void step(const MotionView& view) override {
        if (!script_.is_under_way()) script_.begin(waypoint_script(keys_, view.arm), view.arm, time_scale_);
        script_.step(view.arm);
    }

  private:
    scenes::WaypointConfig keys_;
    double time_scale_;
    Scripted script_;
};

class Pulling final : public ArmMotion {
  public:
    Pulling(const scenes::SceneConfig& scene, int arm, const MotionStart& start)
        : keys_(scene.arms.pull), time_scale_(scene.arms.time_scale), index_(arm), X_WB_(start.X_WB) {
        const auto index = static_cast<size_t>(arm);
        X_WG_ = start.X_WG[index];
        direction_W_ = (X_WG_.translation() - start.X_WG[1 - index].translation()).normalized();
    }

    void step(const MotionView& view) override {
        if (view.next_s >= keys_.at_s / time_scale_) {
            // Slower the harder the thread pulls, so that the drives' lag does not carry past the force.
            const double slack = std::clamp(1.0 - view.world.grip_force_N(index_) / keys_.force_N, 0.0, 1.0);
            const double ramp = std::min(1.0, (view.next_s - keys_.at_s / time_scale_) / kRamp_s);
            way_m_ += slack * ramp * time_scale_ * keys_.speed_m_s * robot::PsmArm::kPeriod_s;
        }
        Isometry3d X_WG = X_WG_;
        X_WG.translation() += std::min(way_m_, keys_.distance_m) * direction_W_;
        const robot::CommandResult result =
            view.arm.controller().servo_cp(X_WB_.inverse() * X_WG * view.arm.psm().tool().X_TG.inverse());
        if (!result) throw std::invalid_argument(view.arm.name() + ": " + result.reason);
    }

  private:
    scenes::PullConfig keys_;
    double time_scale_;
    int index_;
    Isometry3d X_WB_, X_WG_;
    Vector3d direction_W_;
    double way_m_ = 0.0;
};

class MidGrasp final : public ArmMotion {
  public:
    MidGrasp(const scenes::SceneConfig& scene, const MotionStart& start)
        : keys_(scene.arms.mid_grasp),
          way_(scene.arms.psm3.waypoints),
          time_scale_(scene.arms.time_scale),
          start_(start) {}

    void step(const MotionView& view) override {
        if (view.next_s < keys_.at_s / time_scale_) return;
        const robot::Tool& tool = view.arm.psm().tool();
        if (!approach_.is_under_way()) {
            Isometry3d X_CG = aim(view);
            X_CG.translation() -= 2.0 * kApproach_m * X_CG.linear().col(2);
            robot::MotionScript script(tool.X_TG);
            approach_.begin(script.through({X_CG}), view.arm, time_scale_);
        } else if (approach_.is_done() && !grasp_.is_under_way()) {
            // Near it, and with the wrist as it will be, the surgeon sees what the instrument is off by.
            grasp_.begin(robot::grasp_script(tool, aim(view), kApproach_m, keys_.lift_m), view.arm,
                         time_scale_);
        } else if (grasp_.is_done() && !carry_.is_under_way() && !way_.offsets_m.empty()) {
            carry_.begin(waypoint_script(way_, view.arm), view.arm, time_scale_);
        }
        approach_.step(view.arm);
        grasp_.step(view.arm);
        carry_.step(view.arm);
    }

  private:
    /// Grip pose that takes the thread across, as the arm must be told so that its jaws truly get there.
    Isometry3d aim(const MotionView& view) const {
        const sim::ThreadTruth thread = view.world.thread();
        const double s_m = thread.span.s0_m + keys_.fraction * (thread.span.s1_m - thread.span.s0_m);
        const int strand = thread.strand_at(s_m);
        const Isometry3d X_WG = robot::LayoutDefaults::X_WS(
            thread.sample(strand, s_m), thread.tangent(strand, s_m), start_.X_WB.translation());
        const Isometry3d X_TG = view.arm.psm().tool().X_TG;
        Isometry3d X_CG = start_.X_WC.inverse() * X_WG;
        X_CG.translation() +=
            (believed(view.arm, X_TG).translation() - (view.arm.truth().value.X_CT * X_TG).translation());
        return X_CG;
    }

    scenes::MidGraspConfig keys_;
    scenes::WaypointConfig way_;
    double time_scale_;
    MotionStart start_;
    Scripted approach_, grasp_, carry_;
};

}  // namespace

std::unique_ptr<ArmMotion> make_waypoint_motion(const scenes::SceneConfig& scene, int arm) {
    const scenes::WaypointConfig& keys = arm_config(scene, arm).waypoints;
    if (keys.offsets_m.empty())
        throw std::invalid_argument(fmt::format(
            "arms.PSM{}.waypoints.offsets_mm is empty, expected at least one way-point", arm + 1));
    check_waypoints(keys, arm);
    return std::make_unique<Waypoints>(keys, scene.arms.time_scale);
}

std::unique_ptr<ArmMotion> make_pull_motion(const scenes::SceneConfig& scene, int arm,
                                            const MotionStart& start) {
    return std::make_unique<Pulling>(scene, arm, start);
}

std::unique_ptr<ArmMotion> make_mid_grasp_motion(const scenes::SceneConfig& scene, const MotionStart& start) {
    const std::string& name = scene.arms.psm3.tool;
    if (robot::tool(name).kind != robot::ToolKind::kGrasper)
        throw std::invalid_argument("arms.PSM3.tool is " + name + ", expected a grasper for mid_grasp");
    check_waypoints(scene.arms.psm3.waypoints, kScissorsArm);
    return std::make_unique<MidGrasp>(scene, start);
}

}  // namespace atropos::experiments
