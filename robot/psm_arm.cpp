#include "robot/psm_arm.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "robot/path_timing.hpp"

namespace atropos::robot {
namespace {

CommandResult refused(std::string why) {
    return {false, std::move(why)};
}

CommandResult check(const Psm& psm, const Joints& q) {
    const int joint = psm.limits().first_outside(q);
    if (joint < 0) return {};
    IkResult<Joints> outside;
    outside.status = q.allFinite() ? IkStatus::kOutsideLimits : IkStatus::kNotAPose;
    outside.joint = joint;
    outside.value = q[joint];
    return refused(q.allFinite() ? reason(outside) : "joint values are not finite");
}

CommandResult check_ratio(double ratio) {
    if (ratio > 0.0 && ratio <= 1.0) return {};
    return refused("speed ratio must be in (0, 1]");
}

}  // namespace

PsmArm::PsmArm(const Psm& psm, const Joints& q, double jaw_rad, const ArmLimits& limits)
    : psm_(psm), limits_(limits), goal_(q), jaw_goal_rad_(jaw_rad) {
    if (const auto result = check(psm, q); !result) throw std::invalid_argument("PsmArm: " + result.reason);
    for (int i = 0; i < 6; ++i) {
        const auto k = static_cast<size_t>(i);
        joints_[k] = JointServo(limits.joints[k], psm.limits().lower[i], psm.limits().upper[i], q[i]);
    }
    const Tool& tool = psm.tool();
    jaw_ = JointServo(limits.jaw, tool.jaw_min_rad, tool.jaw_max_rad, jaw_rad);
    if (const auto result = jaw_servo_jp(jaw_rad); !result)
        throw std::invalid_argument("PsmArm: " + result.reason);
}

CommandResult PsmArm::start_servo(const Joints& q, Mode mode) {
    if (auto result = check(psm_, q); !result) return result;
    if (mode_ != mode) streamed_ = 0;
    mode_ = mode;
    queue_.clear();
    goal_ = q;
    commanded_ = true;
    return {};
}

CommandResult PsmArm::servo_jp(const Joints& q) {
    return start_servo(q);
}

CommandResult PsmArm::servo_jr(const Joints& dq) {
    return start_servo(goal_ + dq);
}

CommandResult PsmArm::servo_cp(const Eigen::Isometry3d& X_BT) {
    const auto solution = psm_.inverse(X_BT, goal_);
    return solution ? start_servo(solution.q) : refused(reason(solution));
}

CommandResult PsmArm::servo_cr(const Eigen::Isometry3d& X_relative) {
    Eigen::Isometry3d X_BT = psm_.forward(goal_);
    X_BT.translation() += X_relative.translation();
    X_BT.linear() = (X_relative.linear() * X_BT.linear()).eval();
    return servo_cp(X_BT);
}

CommandResult PsmArm::servo_cv(const Twist& V_B) {
    if (!V_B.allFinite()) return refused("velocity is not finite");
    const Joints from = mode_ == Mode::kVelocity ? goal_ : stopping_joints();
    if (auto result = start_servo(from, Mode::kVelocity); !result) return result;
    V_B_ = V_B;
    warning_.clear();
    return {};
}

CommandResult PsmArm::queue_move(Move move) {
    if (mode_ != Mode::kMove) streamed_ = 0;
    mode_ = Mode::kMove;
    move.from = goal_;
    goal_ = move.goal;
    queue_.push_back(std::move(move));
    return {};
}

CommandResult PsmArm::move_jp(const Joints& q, double speed_ratio) {
    if (auto result = check(psm_, q); !result) return result;
    if (auto result = check_ratio(speed_ratio); !result) return result;
    const Joints way = q - goal_;
    MotionLimits along{1e9, 1e9, 1e9};  // of the share of the way, in 1/s and its powers
    for (int i = 0; i < 6; ++i) {
        const MotionLimits& joint = limits_.joints[static_cast<size_t>(i)];
        const double distance = std::abs(way[i]) + 1e-12, r = speed_ratio;
        along.velocity = std::min(along.velocity, r * joint.velocity / distance);
        along.acceleration = std::min(along.acceleration, r * r * joint.acceleration / distance);
        along.jerk = std::min(along.jerk, r * r * r * joint.jerk / distance);
    }
    return queue_move({goal_, q, nullptr, along});
}

CommandResult PsmArm::move_jr(const Joints& dq, double speed_ratio) {
    return move_jp(goal_ + dq, speed_ratio);
}

CommandResult PsmArm::move_cp(const Eigen::Isometry3d& X_BT, double speed_ratio) {
    const auto solution = psm_.inverse(X_BT, goal_);
    return solution ? move_jp(solution.q, speed_ratio) : refused(reason(solution));
}

CommandResult PsmArm::move_line(const Eigen::Isometry3d& X_BT, const PathLimits& limits) {
    if (!is_pose(X_BT)) return refused("not a finite rigid pose");
    try {
        return follow(CartesianPath({psm_.forward(goal_), X_BT}), limits);
    } catch (const std::invalid_argument& error) {
        return refused(error.what());
    }
}

CommandResult PsmArm::follow(const CartesianPath& path, const PathLimits& limits) {
    const Eigen::Isometry3d X = psm_.forward(goal_), X_start = path.at(0.0);
    const double gap = (X.translation() - X_start.translation()).norm();
    const double turn = Eigen::AngleAxisd(Eigen::Matrix3d(X.linear().transpose() * X_start.linear())).angle();
    if (gap > 1e-6 || turn > 1e-4) {
        char text[96];
        std::snprintf(text, sizeof text, "path begins %.3f mm, %.3f deg away from the arm's goal", 1e3 * gap,
                      turn * 57.29577951308232);
        return refused(text);
    }
    const PathTiming timing = time_path(psm_, path, goal_, limits, limits_);
    if (!timing.refusal.empty()) return refused(timing.refusal);
    return queue_move({goal_, timing.end, std::make_shared<const CartesianPath>(path), timing.along});
}

CommandResult PsmArm::jaw_servo_jp(double jaw_rad) {
    return jaw_move_jp(jaw_rad, 1.0);
}

CommandResult PsmArm::jaw_move_jp(double jaw_rad, double speed_ratio) {
    const Tool& tool = psm_.tool();
    if (!(jaw_rad >= tool.jaw_min_rad - kLimitSlack && jaw_rad <= tool.jaw_max_rad + kLimitSlack)) {
        char text[128];
        std::snprintf(text, sizeof text, "jaw %.1f deg, expected %.0f to %.0f", jaw_rad * 57.29577951308232,
                      tool.jaw_min_rad * 57.29577951308232, tool.jaw_max_rad * 57.29577951308232);
        return refused(text);
    }
    if (auto result = check_ratio(speed_ratio); !result) return result;
    jaw_goal_rad_ = jaw_rad;
    jaw_.limit_velocity(speed_ratio * limits_.jaw.velocity);
    return {};
}

void PsmArm::hold() {
    goal_ = stopping_joints();
    queue_.clear();
    mode_ = Mode::kHold;
}

Joints PsmArm::stopping_joints() const {
    Joints q;
    for (int i = 0; i < 6; ++i) {
        const auto k = static_cast<size_t>(i);
        q[i] = std::clamp(joints_[k].stopping_position(), psm_.limits().lower[i], psm_.limits().upper[i]);
    }
    return q;
}

bool PsmArm::stands_at(const Joints& q) const {
    for (int i = 0; i < 6; ++i) {
        const JointServo& joint = joints_[static_cast<size_t>(i)];
        if (!joint.at_rest() || joint.state().position != q[i]) return false;
    }
    return true;
}

// A target that comes at every step is a stream, and its velocity and acceleration are known from its past.
void PsmArm::stream(const Joints& target) {
    Joints velocity = Joints::Zero(), acceleration = Joints::Zero();
    if (streamed_ >= 1) velocity = (target - stream_target_) / kPeriod_s;
    if (streamed_ >= 2) acceleration = (velocity - stream_velocity_) / kPeriod_s;
    for (int i = 0; i < 6; ++i)
        joints_[static_cast<size_t>(i)].follow({target[i], velocity[i], acceleration[i]}, kPeriod_s);
    stream_target_ = target;
    stream_velocity_ = velocity;
    streamed_ = std::min(streamed_ + 1, 2);
}

void PsmArm::step_move() {
    if (queue_.empty()) {
        streamed_ = 0;
        return stream(goal_);
    }
    Move& move = queue_.front();
    if (move.time_s < 0.0) {  // what came before may still have to come to rest
        if (!stands_at(move.from)) {
            streamed_ = 0;
            return stream(move.from);
        }
        move.profile = MotionProfile::to_rest_at({}, move.path ? move.path->length_m() : 1.0, move.along);
        move.time_s = 0.0;
        streamed_ = 2;
        stream_target_ = move.from;
        stream_velocity_.setZero();
    }
    move.time_s += kPeriod_s;
    const bool ended = move.time_s >= move.profile.duration_s();
    if (move.path) {
        const double u = move.profile.at(move.time_s).position;
        const auto solution = psm_.inverse(move.path->at(u), stream_target_);
        stream(ended ? move.goal : solution.q);
        if (ended && stands_at(move.goal)) queue_.pop_front();
        return;
    }
    const Joints way = move.goal - move.from;
    const MotionState s = move.profile.at(move.time_s);
    for (int i = 0; i < 6; ++i)
        joints_[static_cast<size_t>(i)].set_state(ended ? MotionState{move.goal[i], 0.0, 0.0}
                                                        : MotionState{move.from[i] + s.position * way[i],
                                                                      s.velocity * way[i],
                                                                      s.acceleration * way[i]});
    if (ended) queue_.pop_front();
}

void PsmArm::step_velocity() {
    Eigen::Isometry3d X_BT = psm_.forward(goal_);
    X_BT.translation() += kPeriod_s * V_B_.head<3>();
    const Eigen::Vector3d turn = kPeriod_s * V_B_.tail<3>();
    if (const double angle = turn.norm(); angle > 0.0)
        X_BT.linear() = (Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() * X_BT.linear()).eval();
    const auto solution = psm_.inverse(X_BT, goal_);
    if (!solution) {
        warning_ = "servo_cv stopped: " + reason(solution);
        hold();
        streamed_ = 0;
    } else {
        goal_ = solution.q;
    }
    stream(goal_);
}

void PsmArm::step() {
    switch (mode_) {
        case Mode::kHold:
            streamed_ = 0;
            stream(goal_);
            break;
        case Mode::kServo:
            if (!commanded_) streamed_ = 0;
            stream(goal_);
            break;
        case Mode::kVelocity:
            step_velocity();
            break;
        case Mode::kMove:
            step_move();
            break;
    }
    commanded_ = false;
    jaw_.follow({jaw_goal_rad_, 0.0, 0.0}, kPeriod_s);
    ++steps_;
}

Setpoint PsmArm::setpoint() const {
    Setpoint s;
    s.time_s = static_cast<double>(steps_) * kPeriod_s;
    for (int i = 0; i < 6; ++i) {
        s.q[i] = joints_[static_cast<size_t>(i)].state().position;
        s.qd[i] = joints_[static_cast<size_t>(i)].state().velocity;
    }
    s.jaw_rad = jaw_.state().position;
    s.jaw_velocity_rad_s = jaw_.state().velocity;
    return s;
}

bool PsmArm::is_busy() const {
    return mode_ == Mode::kMove && !queue_.empty();
}

bool PsmArm::is_jaw_busy() const {
    return !jaw_.at_rest() || jaw_.state().position != jaw_goal_rad_;
}

}  // namespace atropos::robot
