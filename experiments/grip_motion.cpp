#include <cmath>
#include <numbers>

#include "experiments/testbed.hpp"
#include "robot/layout_defaults.hpp"
#include "scenes/random_stream.hpp"

namespace atropos::experiments {
using Eigen::Isometry3d;
using Eigen::Vector3d;
namespace {

/// Both grips stand where the default scene begins.
class Holding final : public GripMotion {
  public:
    std::array<Isometry3d, 2> X_WG(double) const override { return robot::LayoutDefaults{}.X_WG(); }
};

/// A slow sum of sines a coordinate, common to both grips and between them, that begins at rest.
class Swaying final : public GripMotion {
  public:
    explicit Swaying(const scenes::SceneConfig& scene)
        : start_(robot::LayoutDefaults{}.X_WG()), amplitude_m_(scene.arms.amplitude_m) {
        scenes::RandomStream random(scene.seed, "motion");
        // A sine of amplitude a and frequency f has mean speed 4 a f.
        const double base_hz = scene.arms.speed_m_s / (4.0 * amplitude_m_);
        for (auto& wave : waves_)
            wave = {random.uniform(0.6, 1.2) * base_hz, random.uniform(0.0, 2.0 * std::numbers::pi)};
    }

    std::array<Isometry3d, 2> X_WG(double time_s) const override {
        const double ease = 1.0 - std::exp(-time_s * time_s);
        const auto wave = [&](size_t i) {
            return ease * std::sin(2.0 * std::numbers::pi * waves_[i].hz * time_s + waves_[i].phase_rad);
        };
        const Vector3d common = amplitude_m_ * Vector3d(0.5 * wave(0), wave(1), 0.5 * wave(2));
        const Vector3d apart = 0.25 * amplitude_m_ * Vector3d(wave(3), wave(4), wave(5));
        std::array<Isometry3d, 2> X = start_;
        X[0].translation() += common - apart;
        X[1].translation() += common + apart;
        return X;
    }

  private:
    struct Wave {
        double hz, phase_rad;
    };
    std::array<Isometry3d, 2> start_;
    std::array<Wave, 6> waves_;
    double amplitude_m_;
};

}  // namespace

std::unique_ptr<GripMotion> make_grip_motion(const scenes::SceneConfig& scene) {
    if (scene.arms.psm1.motion == "hold") return std::make_unique<Holding>();
    return std::make_unique<Swaying>(scene);
}

}  // namespace atropos::experiments
