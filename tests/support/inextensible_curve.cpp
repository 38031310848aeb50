#include "tests/support/inextensible_curve.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/random_stream.hpp"

namespace atropos::support {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr double kBurstFrames = 173.0;  // frames from one burst of motion to the next

}  // namespace

InextensibleCurve::InextensibleCurve(const InextensibleCurveOptions& options) : options_(options) {
    scenes::RandomStream random(options.seed, "inextensible curve");
    const auto draw = [&random](std::array<Wave, 3>& waves, double amplitude) {
        for (std::size_t i = 0; i < waves.size(); ++i) {
            const double rate = (0.4 + 0.6 * static_cast<double>(i)) * random.uniform(0.8, 1.25);
            waves[i] = {amplitude / rate * random.uniform(0.5, 1.0), rate, random.uniform(0.0, kTwoPi)};
        }
    };
    for (int m = 0; m < kModes; ++m) {
        draw(bend_[static_cast<std::size_t>(m)], 0.16 / (1.0 + m));
        draw(lift_[static_cast<std::size_t>(m)], 0.09 / (1.0 + m));
    }
    for (std::array<Wave, 3>& axis : translation_) draw(axis, 0.12);
    // The formulae give a shape for each phase; its rate in time follows from the speed wanted.
    double travelled = 0.0;
    const int steps = 400;
    scenes::Polyline before = at_phase(0.0, 0.0, 40);
    for (int i = 1; i <= steps; ++i) {
        scenes::Polyline now = at_phase(0.1 * i, 0.0, 40);
        for (std::size_t j = 0; j < now.points.size(); ++j)
            travelled += (now.points[j] - before.points[j]).norm() / static_cast<double>(now.points.size());
        before = std::move(now);
    }
    phase_per_frame_ = options.speed_m_per_frame * 0.1 * steps / travelled;
}

double InextensibleCurve::wave(const std::array<Wave, 3>& waves, double phase) const {
    double sum = 0.0;
    for (const Wave& w : waves) sum += w.amplitude_rad * std::sin(w.rate_rad * phase + w.offset_rad);
    return sum;
}

// Speed 1 + sum of cosines that are all in phase at a burst (Fejer's kernel: peak harmonics + 1, never
// negative).
double InextensibleCurve::motion_phase(double frame) const {
    const int harmonics = options_.burst_ratio - 1;
    double phase = frame;
    for (int h = 1; h <= harmonics; ++h) {
        const double rate = kTwoPi * h / kBurstFrames;
        const double weight = 2.0 * (1.0 - h / (harmonics + 1.0));
        phase += weight * std::sin(rate * frame) / rate;
    }
    return phase * phase_per_frame_;
}

scenes::Polyline InextensibleCurve::at(double frame, int segments) const {
    return at_phase(motion_phase(frame), frame, segments);
}

scenes::Polyline InextensibleCurve::at_phase(double phase, double frame, int segments) const {
    std::array<double, kModes> bend{};
    std::array<double, kModes> lift{};
    for (std::size_t m = 0; m < kModes; ++m) {
        bend[m] = wave(bend_[m], phase);
        lift[m] = wave(lift_[m], phase);
    }
    const Eigen::Matrix3d frame_C = (Eigen::AngleAxisd(options_.heading_rad, Eigen::Vector3d::UnitZ()) *
                                     Eigen::AngleAxisd(options_.depth_tilt_rad, Eigen::Vector3d::UnitY()) *
                                     Eigen::AngleAxisd(options_.arc_tilt_rad, Eigen::Vector3d::UnitX()))
                                        .toRotationMatrix();
    const double swing = std::cos(kTwoPi * frame / options_.swing_frames);
    const double turning_rad = options_.turning_rad - options_.turning_swing_rad * swing;
    const double turn_middle = 0.5 - options_.travel_share * swing;
    const double step = options_.length_m / segments;
    scenes::Polyline line;
    line.points.reserve(static_cast<std::size_t>(segments + 1));
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    line.points.push_back(p);
    for (int i = 0; i < segments; ++i) {
        const double t = (i + 0.5) / segments;
        double yaw = turning_rad * std::clamp((t - turn_middle) / options_.turning_share, -0.5, 0.5);
        double pitch = 0.0;
        for (std::size_t m = 0; m < kModes; ++m) {
            const double shape = std::cos(std::numbers::pi * static_cast<double>(m + 1) * t);
            yaw += bend[m] * shape;
            pitch += lift[m] * shape;
        }
        const Eigen::Vector3d tangent(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch),
                                      std::sin(pitch));
        p += step * (frame_C * tangent);
        mean += p / segments;
        line.points.push_back(p);
    }
    Eigen::Vector3d shift = options_.centre_C - mean;
    for (std::size_t axis = 0; axis < 3; ++axis)
        shift[static_cast<int>(axis)] += 0.010 * wave(translation_[axis], phase);
    for (Eigen::Vector3d& point : line.points) point += shift;
    return line;
}

}  // namespace atropos::support
