#include <fmt/format.h>

#include <stdexcept>

#include "experiments/testbed.hpp"
#include "robot/layout_defaults.hpp"
#include "robot/manipulation.hpp"

namespace atropos::experiments {
using Eigen::Isometry3d;
namespace {

/// Both grips stand where the default scene begins.
class Holding final : public GripMotion {
  public:
    std::array<Isometry3d, 2> X_WG(double) const override { return robot::LayoutDefaults{}.X_WG(); }
};

/// Smooth random manipulation, defined in the camera's frame.
class Manipulating final : public GripMotion {
  public:
    Manipulating(const scenes::SceneConfig& scene, const Isometry3d& X_WC)
        : X_WC_(X_WC), motion_(start_C(X_WC), options(scene), scene.seed) {}

    std::array<Isometry3d, 2> X_WG(double time_s) const override {
        const std::array<Isometry3d, 2> X_CG = motion_.at(time_s);
        return {X_WC_ * X_CG[0], X_WC_ * X_CG[1]};
    }

  private:
    static std::array<Isometry3d, 2> start_C(const Isometry3d& X_WC) {
        const std::array<Isometry3d, 2> X_WG = robot::LayoutDefaults{}.X_WG();
        return {X_WC.inverse() * X_WG[0], X_WC.inverse() * X_WG[1]};
    }
    static robot::ManipulationOptions options(const scenes::SceneConfig& scene) {
        robot::ManipulationOptions options;
        options.speed_m_s = scene.arms.speed_m_s;
        options.amplitude_m = scene.arms.amplitude_m;
        options.time_scale = scene.arms.time_scale;
        options.thread_length_m = scene.thread.length_m;
        return options;
    }

    Isometry3d X_WC_;
    robot::Manipulation motion_;
};

}  // namespace

std::unique_ptr<GripMotion> make_grip_motion(const scenes::SceneConfig& scene, const Isometry3d& X_WC) {
    const std::string &first = scene.arms.psm1.motion, &second = scene.arms.psm2.motion;
    if (first != second || (first != "hold" && first != "manipulate"))
        throw std::invalid_argument(fmt::format(
            "arms.PSM1.motion is {}, arms.PSM2.motion is {}; expected both hold or both manipulate", first,
            second));
    if (first == "hold") return std::make_unique<Holding>();
    return std::make_unique<Manipulating>(scene, X_WC);
}

}  // namespace atropos::experiments
