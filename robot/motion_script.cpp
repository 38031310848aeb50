#include "robot/motion_script.hpp"

#include <stdexcept>

namespace atropos::robot {

MotionScript& MotionScript::through(std::vector<Eigen::Isometry3d> X_CF, double blend_m,
                                    const PathLimits& limits) {
    steps_.emplace_back(Through{std::move(X_CF), blend_m, limits});
    return *this;
}

MotionScript& MotionScript::jaw(double angle_rad, double speed_ratio) {
    steps_.emplace_back(Jaw{angle_rad, speed_ratio});
    return *this;
}

MotionScript& MotionScript::wait(double duration_s) {
    steps_.emplace_back(Wait{duration_s});
    return *this;
}

MotionScript MotionScript::faster(double factor) const {
    if (!(factor > 0.0)) throw std::invalid_argument("script: time scale must be above 0");
    MotionScript script = *this;
    for (Step& step : script.steps_) {
        if (auto* path = std::get_if<Through>(&step)) {
            path->limits.speed_m_s *= factor;
            path->limits.acceleration_m_s2 *= factor * factor;
            path->limits.jerk_m_s3 *= factor * factor * factor;
        } else if (auto* jaw = std::get_if<Jaw>(&step)) {
            jaw->speed_ratio = std::min(1.0, jaw->speed_ratio * factor);
        } else {
            std::get<Wait>(step).duration_s /= factor;
        }
    }
    return script;
}

MotionScript grasp_script(const Tool& tool, const Eigen::Isometry3d& X_CG, double approach_m, double lift_m,
                          double open_rad) {
    const auto back = [&](double by) {
        Eigen::Isometry3d X = X_CG;
        X.translation() -= by * X_CG.linear().col(2);
        return X;
    };
    MotionScript script(tool.X_TG);
    script.jaw(open_rad).through({back(approach_m)}).through({X_CG}, 0.0, {0.015, 0.2, 4.0});
    script.jaw(tool.jaw_min_rad * 0.25).wait(0.1);
    if (lift_m > 0.0) script.through({back(lift_m)}, 0.0, {0.015, 0.2, 4.0});
    return script;
}

MotionScript pull_script(const Tool& tool, const Eigen::Isometry3d& X_CG, const Eigen::Vector3d& direction_C,
                         double distance_m, double speed_m_s) {
    Eigen::Isometry3d X = X_CG;
    X.translation() += distance_m * direction_C.normalized();
    MotionScript script(tool.X_TG);
    return script.through({X}, 0.0, {speed_m_s, 10.0 * speed_m_s, 200.0 * speed_m_s});
}

CommandResult ScriptRunner::begin(const MotionScript::Step& step) {
    PsmArm& controller = arm_->controller();
    if (const auto* jaw = std::get_if<MotionScript::Jaw>(&step))
        return controller.jaw_move_jp(jaw->angle_rad, jaw->speed_ratio);
    if (const auto* wait = std::get_if<MotionScript::Wait>(&step)) {
        wait_until_s_ = arm_->time_s() + wait->duration_s;
        return {};
    }
    const auto& through = std::get<MotionScript::Through>(step);
    std::vector<Eigen::Isometry3d> X_BT = {controller.psm().forward(controller.goal())};
    for (const Eigen::Isometry3d& X_CF : through.X_CF)
        X_BT.push_back(arm_->command(X_CF * script_.X_TF().inverse()));
    try {
        return controller.follow(CartesianPath(std::move(X_BT), through.blend_m), through.limits);
    } catch (const std::invalid_argument& error) {
        return {false, error.what()};
    }
}

bool ScriptRunner::finished(const MotionScript::Step& step) const {
    if (std::holds_alternative<MotionScript::Jaw>(step)) return !arm_->controller().is_jaw_busy();
    if (std::holds_alternative<MotionScript::Wait>(step)) return arm_->time_s() >= wait_until_s_ - 1e-9;
    return !arm_->controller().is_busy();
}

void ScriptRunner::step() {
    if (under_way_ && finished(script_.steps()[next_])) {
        under_way_ = false;
        ++next_;
    }
    if (under_way_ || next_ >= script_.steps().size()) return;
    const CommandResult result = begin(script_.steps()[next_]);
    under_way_ = result.accepted;
    if (result.accepted) return;
    failure_ = "step " + std::to_string(next_) + ": " + result.reason;
    arm_->controller().hold();
    next_ = script_.steps().size();
}

}  // namespace atropos::robot
