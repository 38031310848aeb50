#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "robot/layout.hpp"
#include "robot/recording.hpp"

namespace atropos::robot {
namespace {

// Recorded poses in the arm's base: frame, then registration.
Eigen::Isometry3d to_base(const Recording& recording, const ReplayFrames& frames, const std::string& name) {
    const std::string& frame = recording.frame_id;
    if (frame == "C") return frames.X_BC * frames.X_registration;
    if (frame == "ECM") return frames.X_BC * half_turn_about_z() * frames.X_registration;
    if (frame.ends_with("_base")) return frames.X_registration;
    throw std::runtime_error(name + ": frame_id '" + frame + "', expected C, ECM or the arm's base");
}

}  // namespace

void Replay::clamp(Joints& q, const std::string& where) {
    const auto& limits = psm_.limits();
    for (int i = 0; i < 6; ++i) {
        const double inside = std::clamp(q[i], limits.lower[i], limits.upper[i]);
        const double beyond = std::abs(q[i] - inside);
        if (beyond > (i == 2 ? kLengthSlack_m : kAngleSlack_rad))
            throw std::runtime_error(where + std::string(kJointNames[static_cast<size_t>(i)]) + " " +
                                     std::to_string(beyond) + (i == 2 ? " m" : " rad") +
                                     " beyond its limit, expected at most " + (i == 2 ? "0.001" : "0.01"));
        clamped_ += beyond > kLimitSlack;
        q[i] = inside;
    }
}

void Replay::clamp_jaw(double& jaw, const std::string& where) {
    const double inside = std::clamp(jaw, psm_.tool().jaw_min_rad, psm_.tool().jaw_max_rad);
    if (std::abs(jaw - inside) > kAngleSlack_rad)
        throw std::runtime_error(where + "jaw " + std::to_string(jaw) + " rad beyond its range");
    clamped_ += std::abs(jaw - inside) > kLimitSlack;
    jaw = inside;
}

Replay::Replay(const Recording& recording, const Psm& psm, const ReplayFrames& frames,
               const std::string& name)
    : psm_(psm) {
    if (recording.size() == 0) throw std::runtime_error(name + ": no rows, expected at least one");
    const bool posed = recording.frame_id != "joints";
    const Eigen::Isometry3d X_BF = posed ? to_base(recording, frames, name) : Eigen::Isometry3d::Identity();
    for (size_t i = 0; i < recording.size(); ++i) {
        const std::string where = name + ":" + std::to_string(recording.line[i]) + ": ";
        time_s_.push_back(recording.time_s[i] - recording.time_s[0]);
        if (i > 0 && !(time_s_[i] > time_s_[i - 1]))
            throw std::runtime_error(where + "time does not grow, expected later than the row before");
        // Joints in the file beside poses only say which turn of the roll is meant.
        Joints q = recording.q.empty() ? (i > 0 ? q_.back() : Joints(Joints::Zero())) : recording.q[i];
        if (posed) {
            const auto solution = psm.inverse(X_BF * recording.X_FT[i], q);
            if (!solution && solution.status != IkStatus::kOutsideLimits)
                throw std::runtime_error(where + reason(solution));
            q = solution.q;
        }
        clamp(q, where);
        q_.push_back(q);
        double jaw = recording.jaw_rad.empty() ? 0.0 : recording.jaw_rad[i];
        clamp_jaw(jaw, where);
        jaw_rad_.push_back(jaw);
    }
}

// Catmull-Rom with uneven steps: the slope at a row is that of the parabola through it and its neighbours.
Joints Replay::joints(double time_s) const {
    if (time_s <= 0.0 || q_.size() == 1) return q_.front();
    if (time_s >= time_s_.back()) return q_.back();
    const auto i =
        static_cast<size_t>(std::upper_bound(time_s_.begin(), time_s_.end(), time_s) - time_s_.begin()) - 1;
    const auto slope = [&](size_t k) -> Joints {
        if (k == 0 || k + 1 == q_.size()) return Joints::Zero();
        const double before = time_s_[k] - time_s_[k - 1], after = time_s_[k + 1] - time_s_[k];
        const Joints left = (q_[k] - q_[k - 1]) / before, right = (q_[k + 1] - q_[k]) / after;
        return (after * left + before * right) / (before + after);
    };
    const double h = time_s_[i + 1] - time_s_[i], t = (time_s - time_s_[i]) / h, s = 1.0 - t;
    const Joints q = s * s * (1.0 + 2.0 * t) * q_[i] + t * t * (1.0 + 2.0 * s) * q_[i + 1] +
                     h * s * t * (s * slope(i) - t * slope(i + 1));
    return q.cwiseMax(psm_.limits().lower).cwiseMin(psm_.limits().upper);
}

double Replay::jaw_rad(double time_s) const {
    if (time_s <= 0.0 || q_.size() == 1) return jaw_rad_.front();
    if (time_s >= time_s_.back()) return jaw_rad_.back();
    const auto i =
        static_cast<size_t>(std::upper_bound(time_s_.begin(), time_s_.end(), time_s) - time_s_.begin()) - 1;
    const double t = (time_s - time_s_[i]) / (time_s_[i + 1] - time_s_[i]);
    return (1.0 - t) * jaw_rad_[i] + t * jaw_rad_[i + 1];
}

CommandResult Replay::drive(PsmArm& arm, double time_s) const {
    if (auto result = arm.jaw_servo_jp(jaw_rad(time_s)); !result) return result;
    return arm.servo_jp(joints(time_s));
}

}  // namespace atropos::robot
