#include "robot/manipulation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace atropos::robot {
namespace {

using Eigen::Vector3d;

// At unit rate one radian a second is the middle of the band; the rate then sets the speed.
constexpr double kLow_rad_s = 0.6, kHigh_rad_s = 1.4;

std::array<SmoothRandom, 3> random3(scenes::RandomStream& random, const Vector3d& bound) {
    return {SmoothRandom(random, bound.x(), kLow_rad_s, kHigh_rad_s),
            SmoothRandom(random, bound.y(), kLow_rad_s, kHigh_rad_s),
            SmoothRandom(random, bound.z(), kLow_rad_s, kHigh_rad_s)};
}

// Grows from 0 to 1 with two continuous derivatives.
double ramp(double t) {
    const double u = std::clamp(t, 0.0, 1.0);
    return u * u * u * (10.0 + u * (-15.0 + 6.0 * u));
}

}  // namespace

Vector3d Manipulation::value(const Random3& random, double t) {
    return {random[0].at(t), random[1].at(t), random[2].at(t)};
}

Manipulation::Manipulation(const std::array<Eigen::Isometry3d, 2>& X_CG, const ManipulationOptions& options,
                           std::uint64_t seed)
    : X_CG_(X_CG), options_(options) {
    const Vector3d between = X_CG[1].translation() - X_CG[0].translation();
    const double distance = between.norm(), length = options.thread_length_m;
    if (!(distance >= options.span_min * length && distance <= options.span_max * length))
        throw std::invalid_argument(
            "manipulation: grips " + std::to_string(1e3 * distance) +
            " mm apart, expected between span_min and span_max of the thread's length");
    if (!(options.speed_m_s >= 0 && options.amplitude_m > 0 && options.time_scale > 0 &&
          options.opposed_m >= 0 && options.tilt_rad >= 0 && options.tremor_rms_m >= 0 &&
          options.ramp_s >= 0))
        throw std::invalid_argument("manipulation: speeds and amplitudes must not be negative");
    along_ = between / distance;
    scenes::RandomStream random(seed, "motion.manipulation");
    common_ = random3(random, options.amplitude_m * Vector3d(1.0, 0.6, 0.6));
    // Opposed motion goes across the line between the grips, so that it only ever lengthens their distance.
    across_ << along_.unitOrthogonal(), along_.cross(along_.unitOrthogonal());
    const double sideways = 2.0 * std::numbers::sqrt2 * options.opposed_m;
    const double longest =
        std::sqrt(std::max(0.0, std::pow(options.span_max * length, 2) - sideways * sideways));
    const double room = std::min(longest - distance, distance - options.span_min * length);
    stretch_ = SmoothRandom(random, 0.5 * std::max(0.0, room), kLow_rad_s, kHigh_rad_s);
    const double opposed = longest > distance ? options.opposed_m : 0.0;
    for (auto& o : opposed_) o = SmoothRandom(random, opposed, kLow_rad_s, kHigh_rad_s);
    for (auto& tilt : tilt_) tilt = random3(random, Vector3d::Constant(options.tilt_rad));
    tremor_ = Tremor(options.tremor_rms_m, seed);
    rate_ = rate_for_speed();
}

// The rate at which the way of the common motion during the window is as long as asked for.
double Manipulation::rate_for_speed() const {
    const double way = options_.speed_m_s * options_.speed_window_s, du = 0.01;
    double sum = 0.0, u = 0.0;
    for (; sum < way && u < 1e4; u += du)
        sum +=
            du * Eigen::Vector3d(common_[0].rate_at(u), common_[1].rate_at(u), common_[2].rate_at(u)).norm();
    return u / options_.speed_window_s;
}

std::array<Eigen::Isometry3d, 2> Manipulation::at(double time_s) const {
    const double t = time_s * options_.time_scale, u = rate_ * t;
    const double weight = options_.ramp_s > 0.0 ? ramp(t / options_.ramp_s) : 1.0;
    const Vector3d common = value(common_, u);
    const Vector3d opposed =
        across_ * Eigen::Vector2d(opposed_[0].at(u), opposed_[1].at(u)) + stretch_.at(u) * along_;
    std::array<Eigen::Isometry3d, 2> X = X_CG_;
    for (size_t i = 0; i < 2; ++i) {
        const double sign = i == 0 ? -1.0 : 1.0;
        // Tremor is the hand's, it does not speed up with the motion.
        X[i].translation() += weight * (common + sign * opposed + tremor_.at(i, time_s));
        const Vector3d tilt = weight * value(tilt_[i], u);
        if (const double angle = tilt.norm(); angle > 0.0)
            X[i].rotate(Eigen::AngleAxisd(angle, tilt / angle));
    }
    return X;
}

}  // namespace atropos::robot
