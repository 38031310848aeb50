#pragma once

#include <cmath>
#include <deque>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "robot/layout_defaults.hpp"
#include "robot/robot_arm.hpp"
#include "robot/scissors_command.hpp"
#include "scenes/polyline.hpp"
#include "scenes/random_stream.hpp"
#include "scenes/stereo_rig.hpp"

namespace atropos::robot {

/// A kinematic world for the scissors command: a thread of known form sags and swings between two imperfect
/// arms on random smooth paths, a tracker of stated noise and latency sees it, images tell the blades' offset
/// and whether the thread is cut.
struct ScissorsWorldOptions {
    scenes::ArmAccuracy accuracy = scenes::ArmAccuracy::kCalibrated;
    double speed_m_s = 0.015;  ///< RMS, of each grip
    double rate_hz = 30.0, latency_s = 0.03;
    double tracking_lateral_m = 0.0001, tracking_depth_m = 0.0004;
    double offset_lateral_m = 0.0003, offset_depth_m = 0.0015;
    bool offsets = true;
    double command_s = 1.0;
    double duration_s = 16.0;
    ScissorsOptions scissors;
    std::function<void(scenes::ThreadEstimate&, double)> tamper;  ///< faults of the tracker
    std::function<bool(double)> frame_dropped;
    std::optional<double> stall_s;        ///< the scissors arm's encoders freeze
    std::optional<double> already_cut_s;  ///< somebody else was faster
    bool blunt = false;                   ///< the blades cut nothing
    double slip_m_s = 0.0;                ///< span pulled out of jaw 1, after the command
    std::vector<scenes::Capsule> obstacles_C;
    std::function<scenes::Capsule(double)> visitor_C;  ///< an obstacle that moves
    std::function<void(const class ScissorsWorld&)> watch;
};

struct ScissorsOutcome {
    ScissorsStatus status;
    bool closed = false;             ///< the blades met
    bool severed = false;            ///< with the thread between them
    double error_m = 0.0;            ///< along the thread from the true place
    bool gate_was_shut = false;      ///< when the blades were told to close
    double target_error_m = 0.0;     ///< predicted against true place, along the thread, when the blades met
    double blade_error_m = 0.0;      ///< believed against true blade point, along the thread
    double depth_error_m = 0.0;      ///< thread to blade plane's middle, along the viewing ray
    double predicted_miss_m = 0.0;   ///< as the gate saw it
    double least_clearance_m = 1.0;  ///< true, shafts and blades against the other arms
    double cut_s = 0.0;
};

class ScissorsWorld {
  public:
    ScissorsWorld(const ScissorsWorldOptions& options, std::uint64_t seed)
        : options_(options),
          noise_(seed, "test.tracker"),
          layout_(default_layout()),
          tree_(frame_tree(layout_, scenes::rig_preset("paper").rig)),
          X_CW_(tree_.pose("C", "W")) {
        scenes::RandomStream motion(seed, "test.motion");
        for (auto& axis : waves_)
            for (Wave& w : axis)
                w = {motion.uniform(0.15, 0.45), motion.uniform(0.0, 2.0 * std::numbers::pi),
                     motion.normal()};
        for (Wave& w : swing_)
            w = {motion.uniform(0.3, 0.6), motion.uniform(0.0, 2.0 * std::numbers::pi),
                 motion.uniform(0.5, 1.0)};
        scale_waves();
        const Imperfection imperfection = Imperfection::of(options.accuracy);
        for (size_t i = 0; i < 2; ++i) {
            const Psm psm(tool(layout_.arms[i].tool));
            const auto q = joints_for(psm, layout_.arms[i].X_WB, X_WG(i, 0.0), psm.tool().X_TG);
            arms_.push_back(std::make_unique<RobotArm>(layout_.arms[i], tree_, q.q, defaults_.holder_jaw_rad,
                                                       imperfection, seed));
        }
        const Psm psm(tool(layout_.arms[2].tool));
        const Eigen::Vector3d p_WB = layout_.arms[2].X_WB.translation();
        const auto q = joints_for(psm, layout_.arms[2].X_WB, defaults_.X_WS_parked(p_WB), *psm.tool().X_TS);
        arms_.push_back(std::make_unique<RobotArm>(layout_.arms[2], tree_, q.q, defaults_.parked_jaw_rad,
                                                   imperfection, seed));
        options_.scissors.registration_sigma_m = options.accuracy == scenes::ArmAccuracy::kPerfect ? 1e-4
                                                 : options.accuracy == scenes::ArmAccuracy::kCalibrated
                                                     ? 0.0019
                                                     : 0.004;
        command_ =
            std::make_unique<ScissorsCommand>(options_.scissors, arms_[2]->controller(), arms_[2]->X_CB());
    }

    double time_s() const { return time_s_; }
    const ScissorsStatus& status() const { return command_->status(); }
    const RobotArm& arm(size_t i) const { return *arms_[i]; }
    const Eigen::Isometry3d& X_CW() const { return X_CW_; }
    const Layout& layout() const { return layout_; }

    /// The thread as it is now, in C.
    scenes::Polyline thread_C() const {
        std::array<Eigen::Vector3d, 2> grip;
        for (size_t i = 0; i < 2; ++i)
            grip[i] = (arms_[i]->truth().value.X_CT * arms_[i]->psm().tool().X_TG).translation();
        const Eigen::Vector3d down = X_CW_.linear() * -Eigen::Vector3d::UnitZ();
        const Eigen::Vector3d side = X_CW_.linear() * Eigen::Vector3d::UnitY();
        const double half = 0.5 * (grip[1] - grip[0]).norm();
        const double slip = std::max(0.0, time_s_ - options_.command_s) * options_.slip_m_s;
        const double length = defaults_.thread_length_m + slip;
        // Parabola of the wanted length, to first order in its sag.
        const double sag = std::sqrt(std::max(1e-6, 0.75 * half * (length - 2.0 * half)));
        scenes::Polyline thread;
        for (int i = 0; i <= 100; ++i) {
            const double u = i / 100.0, hump = 4.0 * u * (1.0 - u);
            thread.points.push_back((1.0 - u) * grip[0] + u * grip[1] +
                                    hump * (sag * down + 0.003 * sum(swing_, time_s_) * side));
        }
        return thread;
    }

    ScissorsOutcome run() {
        while (time_s_ < options_.duration_s && !command_->status().finished) step();
        outcome_.status = command_->status();
        return outcome_;
    }

    void step() {
        for (size_t i = 0; i < 2; ++i)
            arms_[i]->controller().servo_cp(layout_.arms[i].X_WB.inverse() * X_WG(i, time_s_) *
                                            arms_[i]->psm().tool().X_TG.inverse());
        const ScissorsInput input = sense();
        const ScissorsState before = command_->status().state;
        command_->step(input);
        if (before != ScissorsState::kClose && status().state == ScissorsState::kClose) {
            outcome_.gate_was_shut |= !status().gate_open;
            outcome_.predicted_miss_m = status().predicted_miss_m;
        }
        for (auto& arm : arms_) arm->step();
        ++steps_;
        time_s_ = static_cast<double>(steps_) * PsmArm::kPeriod_s;
        judge_cut();
        if (steps_ % 10 == 0) measure_clearance();
        if (options_.watch) options_.watch(*this);
    }

  private:
    struct Wave {
        double hz, phase, amplitude;
    };
    static double sum(const std::array<Wave, 3>& waves, double t) {
        double value = 0.0;
        for (const Wave& w : waves)
            value += w.amplitude * std::sin(2.0 * std::numbers::pi * w.hz * t + w.phase);
        return value;
    }

    // Both grips share most of their motion, so that the thread never comes taut.
    void scale_waves() {
        double square = 0.0;
        for (size_t axis = 0; axis < 3; ++axis)
            for (const Wave& w : waves_[axis])
                square += 0.5 * std::pow(2.0 * std::numbers::pi * w.hz * w.amplitude, 2);
        const double scale = options_.speed_m_s / std::sqrt(square);
        for (auto& axis : waves_)
            for (Wave& w : axis) w.amplitude *= scale;
    }

    Eigen::Isometry3d X_WG(size_t i, double t) const {
        Eigen::Isometry3d X = defaults_.X_WG()[i];
        const double ramp = 1.0 - std::exp(-t * t / 0.1);
        for (int axis = 0; axis < 3; ++axis)
            X.translation()[axis] += ramp * (sum(waves_[static_cast<size_t>(axis)], t) +
                                             0.3 * sum(waves_[3 + i], t * (1.0 + 0.1 * axis)));
        return X;
    }

    Eigen::Vector3d noise_along_ray(const Eigen::Vector3d& p_C, double lateral, double depth) {
        const Eigen::Vector3d v = p_C.normalized(), n(noise_.normal(), noise_.normal(), noise_.normal());
        return lateral * (n - n.dot(v) * v) + depth * n.dot(v) * v;
    }

    ScissorsInput sense() {
        ScissorsInput input;
        input.time_s = time_s_;
        input.commanded = time_s_ >= options_.command_s;
        input.scissors = arms_[2]->measured();
        if (options_.stall_s && time_s_ >= *options_.stall_s) {
            if (!stalled_) stalled_ = input.scissors;
            stalled_->value.time_s = input.scissors.value.time_s;
            input.scissors = *stalled_;
        }
        others_.clear();
        for (size_t i = 0; i < 2; ++i) {
            input.holders[i] = arms_[i]->measured();
            for (const auto& c : arms_[i]->measured_capsules_C().value) others_.push_back(c);
        }
        const scenes::Capsule scope = Ecm().capsule(layout_.ecm_joints);
        const Eigen::Isometry3d X_CEcm = X_CW_ * layout_.X_WEcm;
        others_.push_back({X_CEcm * scope.a, X_CEcm * scope.b, scope.radius_m});
        others_.insert(others_.end(), options_.obstacles_C.begin(), options_.obstacles_C.end());
        if (options_.visitor_C) others_.push_back(options_.visitor_C(time_s_));
        input.others_C = others_;
        capture();
        if (!under_way_.empty() && under_way_.front().first <= time_s_ + 1e-9) {
            arrived_ = under_way_.front().second;
            under_way_.pop_front();
            input.estimate = &arrived_;
            if (options_.offsets) input.blade_offset = offset();
            input.cut_check =
                CutCheck{time_s_ - options_.latency_s, is_cut() ? CutEvidence::kCut : CutEvidence::kIntact};
        }
        return input;
    }

    bool is_cut() const { return cut_ || (options_.already_cut_s && time_s_ >= *options_.already_cut_s); }

    void capture() {
        const double period = 1.0 / options_.rate_hz;
        if (time_s_ + 1e-9 < static_cast<double>(frames_) * period) return;
        ++frames_;
        if (options_.frame_dropped && options_.frame_dropped(time_s_)) return;
        scenes::ThreadEstimate estimate;
        estimate.capture_time_s = time_s_;
        estimate.status = cut_ ? scenes::TrackStatus::kLost : scenes::TrackStatus::kTracking;
        estimate.confidence = 0.95;
        const scenes::Polyline thread = thread_C().resampled(101);
        const double step = thread.length_m() / 100.0;
        // Half of the variance stays from frame to frame, as in a real tracker.
        const double a = options_.tracking_lateral_m, b = options_.tracking_depth_m, h = std::sqrt(0.5);
        bias_ = 0.9 * bias_ + std::sqrt(1.0 - 0.81) * noise_along_ray(thread.points[50], h * a, h * b);
        const Eigen::Vector3d fresh = noise_along_ray(thread.points[50], h * a, h * b);
        if (!cut_)
            for (size_t i = 0; i < thread.points.size(); ++i)
                estimate.samples.push_back(
                    {static_cast<double>(i) * step, thread.points[i] + bias_ + fresh, a, b});
        if (options_.tamper) options_.tamper(estimate, time_s_);
        under_way_.push_back({time_s_ + options_.latency_s, estimate});
    }

    InstrumentOffset offset() {
        const Eigen::Isometry3d& X_TS = *arms_[2]->psm().tool().X_TS;
        const Eigen::Vector3d truth = (arms_[2]->truth().value.X_CT * X_TS).translation();
        const Eigen::Vector3d measured = (arms_[2]->measured().value.X_CT * X_TS).translation();
        const double a = options_.offset_lateral_m, b = options_.offset_depth_m;
        return {time_s_ - options_.latency_s, truth - measured + noise_along_ray(truth, a, b), a, b};
    }

    // The blades meet: what lies in their plane between pin and points is cut.
    void judge_cut() {
        const double jaw = arms_[2]->truth().value.jaw_rad;
        const bool meet =
            last_jaw_ > 0.03 && jaw <= 0.03 && time_s_ > options_.command_s && !status().aborted;
        last_jaw_ = jaw;
        if (!meet || cut_ || status().close_time_s < 0.0) return;
        outcome_.closed = true;
        outcome_.cut_s = time_s_;
        const Eigen::Isometry3d X_ST =
            (arms_[2]->truth().value.X_CT * *arms_[2]->psm().tool().X_TS).inverse();
        const scenes::Polyline thread = thread_C().resampled(1001);
        const double blade_z = arms_[2]->psm().tool().X_TS->translation().z(),
                     step = thread.length_m() / 1000.0;
        const double half = std::tan(0.5 * arms_[2]->psm().tool().jaw_max_rad);
        const double wanted = cut_arc_length_m(options_.scissors.place, thread.length_m());
        const Eigen::Vector3d place = thread.point_at(wanted), along = status().tangent_C;
        const Eigen::Vector3d blade = X_ST.inverse().translation();
        outcome_.target_error_m = (status().target_C - place).dot(along);
        outcome_.blade_error_m = (status().X_CS.translation() - blade).dot(along);
        outcome_.depth_error_m = (place - blade).dot(place.normalized());
        for (size_t i = 0; i < 1000; ++i) {
            const Eigen::Vector3d p = X_ST * thread.points[i], n = X_ST * thread.points[i + 1];
            const double z = blade_z + p.z();
            if (p.y() * n.y() > 0.0 || z < 0.0015 || z > 0.0105 || std::abs(p.x()) > z * half) continue;
            outcome_.severed = true;
            outcome_.error_m = std::abs(static_cast<double>(i) * step - wanted);
            cut_ = !options_.blunt;
        }
    }

    void measure_clearance() {
        const auto scissors = arms_[2]->true_capsules_W().value;
        for (size_t i = 0; i < 2; ++i)
            for (const auto& a : scissors)
                for (const auto& b : arms_[i]->true_capsules_W().value)
                    outcome_.least_clearance_m =
                        std::min(outcome_.least_clearance_m, scenes::clearance_m(a, b));
    }

    ScissorsWorldOptions options_;
    scenes::RandomStream noise_;
    Layout layout_;
    LayoutDefaults defaults_;
    FrameTree tree_;
    Eigen::Isometry3d X_CW_;
    std::array<std::array<Wave, 3>, 5> waves_;  // common x, y, z; then each grip's own
    std::array<Wave, 3> swing_;
    std::vector<std::unique_ptr<RobotArm>> arms_;
    std::unique_ptr<ScissorsCommand> command_;
    Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();
    std::deque<std::pair<double, scenes::ThreadEstimate>> under_way_;
    scenes::ThreadEstimate arrived_;
    std::vector<scenes::Capsule> others_;
    std::optional<Measured<ArmState>> stalled_;
    std::int64_t steps_ = 0, frames_ = 0;
    double time_s_ = 0.0, last_jaw_ = 0.0;
    bool cut_ = false;
    ScissorsOutcome outcome_;
};

}  // namespace atropos::robot
