#include "robot/arm_team.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <stdexcept>

namespace atropos::robot {

ArmTeam::ArmTeam(std::vector<RobotArm> arms, const scenes::Capsule& endoscope_C, const TeamLimits& limits)
    : arms_(std::move(arms)), endoscope_C_{endoscope_C}, limits_(limits) {
    apart_m_ = stopping_clearances_m();
}

size_t ArmTeam::index(std::string_view name) const {
    std::string known;
    for (size_t i = 0; i < arms_.size(); ++i) {
        if (arms_[i].name() == name) return i;
        known += (known.empty() ? "" : ", ") + arms_[i].name();
    }
    throw std::invalid_argument("no arm '" + std::string(name) + "', expected one of " + known);
}

RobotArm& ArmTeam::arm(std::string_view name) {
    return arms_[index(name)];
}

Capsules ArmTeam::capsules_C(size_t arm, const Joints& q, double jaw_rad) const {
    const RobotArm& a = arms_[arm];
    Capsules all = a.psm().capsules(q, jaw_rad);
    for (scenes::Capsule& c : all) c = {a.X_CB() * c.a, a.X_CB() * c.b, c.radius_m};
    return all;
}

CommandResult ArmTeam::check_move(std::string_view name, const Joints& q) const {
    const size_t moving = index(name);
    const Joints from = arms_[moving].controller().goal();
    const double jaw = arms_[moving].controller().setpoint().jaw_rad;
    const MovingCapsules sweep = [&](double t) { return capsules_C(moving, from + t * (q - from), jaw); };
    const auto check = [&](const Capsules& still, const std::string& who) -> CommandResult {
        const Sweep s = swept_clearance(
            sweep, [&](double) { return still; }, 0.25e-3, limits_.planned_m);
        if (s.clearance_m >= limits_.planned_m) return {};
        char text[128];
        std::snprintf(text, sizeof text, "would pass %s at %.1f mm, expected %.1f", who.c_str(),
                      1e3 * s.clearance_m, 1e3 * limits_.planned_m);
        return {false, text};
    };
    if (auto result = check(endoscope_C_, "the endoscope"); !result) return result;
    for (size_t i = 0; i < arms_.size(); ++i) {
        if (i == moving) continue;
        const PsmArm& other = arms_[i].controller();
        if (auto result = check(capsules_C(i, other.goal(), other.setpoint().jaw_rad), arms_[i].name());
            !result)
            return result;
    }
    return {};
}

CommandResult ArmTeam::move_jp(std::string_view name, const Joints& q, double speed_ratio) {
    RobotArm& a = arm(name);
    if (const int joint = a.psm().limits().first_outside(q); joint >= 0)
        return a.controller().move_jp(q, speed_ratio);  // refuses, and says why
    if (auto result = check_move(name, q); !result) return result;
    return a.controller().move_jp(q, speed_ratio);
}

double ArmTeam::clearance_m() const {
    double least = std::numeric_limits<double>::infinity();
    std::vector<Capsules> all;
    for (size_t i = 0; i < arms_.size(); ++i) {
        const Setpoint s = arms_[i].controller().setpoint();
        all.push_back(capsules_C(i, s.q, s.jaw_rad));
        least = std::min(least, robot::clearance_m(all.back(), endoscope_C_));
        for (size_t j = 0; j < i; ++j) least = std::min(least, robot::clearance_m(all[i], all[j]));
    }
    return least;
}

std::vector<double> ArmTeam::stopping_clearances_m() const {
    std::vector<Capsules> stopped;
    std::vector<double> apart;
    for (size_t i = 0; i < arms_.size(); ++i) {
        const PsmArm& c = arms_[i].controller();
        stopped.push_back(capsules_C(i, c.stopping_joints(), c.setpoint().jaw_rad));
        apart.push_back(robot::clearance_m(stopped[i], endoscope_C_));
    }
    for (size_t i = 0; i < arms_.size(); ++i)
        for (size_t j = 0; j < i; ++j) apart.push_back(robot::clearance_m(stopped[i], stopped[j]));
    return apart;
}

// Goes back to the state before the step, which could still stop well, and stops.
void ArmTeam::keep_apart(const std::vector<PsmArm>& before, const std::vector<double>& apart_before) {
    std::vector<char> held(arms_.size(), 0);
    const auto check = [&](size_t pair, size_t i, size_t j) {
        const double then = apart_m_[pair], left = apart_before[pair] - limits_.floor_m;
        if (then >= limits_.slow_m || then - limits_.floor_m >= left - 0.02 * std::max(0.0, left)) return;
        held[i] = 1;
        if (j < arms_.size()) held[j] = 1;
        warning_ = arms_[i].name() + " stopped, too near to " +
                   (j < arms_.size() ? arms_[j].name() : "the endoscope");
        ++stops_;
    };
    size_t pair = 0;
    for (; pair < arms_.size(); ++pair) check(pair, pair, arms_.size());
    for (size_t i = 0; i < arms_.size(); ++i)
        for (size_t j = 0; j < i; ++j) check(pair++, i, j);
    bool any = false;
    for (size_t i = 0; i < arms_.size(); ++i) {
        if (!held[i]) continue;
        PsmArm& controller = arms_[i].controller();
        controller = before[i];
        controller.hold();
        controller.step();
        any = true;
    }
    if (any) apart_m_ = stopping_clearances_m();
}

void ArmTeam::step() {
    // Only arms this near can come too near within a period.
    const bool watch = *std::min_element(apart_m_.begin(), apart_m_.end()) < 0.010;
    std::vector<PsmArm> before;
    if (watch)
        for (const RobotArm& arm : arms_) before.push_back(arm.controller());
    for (RobotArm& arm : arms_) arm.controller().step();
    const std::vector<double> apart_before = std::move(apart_m_);
    apart_m_ = stopping_clearances_m();
    if (watch) keep_apart(before, apart_before);
    for (RobotArm& arm : arms_) arm.step_drives();
}

}  // namespace atropos::robot
