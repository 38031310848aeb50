#pragma once

#include <memory>

#include "sim/hanging_curve.hpp"
#include "sim/world.hpp"

namespace atropos::sim::testing {

/// Two bare grippers that hold a thread by its ends, `span_m` apart along x, thread leaving along their y
/// axes, and bare scissors (instrument 2) parked aside. Grip frames: z down, y along x_W.
struct HeldThread {
    World world;
    ThreadOptions options;
    Eigen::Isometry3d X_WG[2];

    explicit HeldThread(double span_m = 0.05, double length_m = 0.07, ThreadOptions thread = {},
                        WorldOptions world_options = {})
        : world(world_options), options(thread) {
        for (int k = 0; k < 2; ++k) {
            InstrumentOptions gripper;
            gripper.name = k == 0 ? "PSM1" : "PSM2";
            gripper.jaws = JawGeometry{};
            world.add_instrument(gripper);
            X_WG[k] = frame({(k == 0 ? -0.5 : 0.5) * span_m, 0, 0});
            world.set_jaws(k, X_WG[k], 0.0);
        }
        InstrumentOptions scissors;
        scissors.name = "PSM3";
        scissors.blades = BladeGeometry{};
        world.add_instrument(scissors);
        world.set_blades(2, frame({0, 0.1, 0.1}), 0.6);
        options.length_m = length_m;
        const Eigen::Vector3d along = Eigen::Vector3d::UnitX();
        world.add_thread(
            hanging_curve({X_WG[0].translation(), along}, {X_WG[1].translation(), along}, length_m), options);
        const double half_edge = 0.5 * length_m / options.edges;
        world.hold(0, half_edge, Eigen::Vector3d::UnitY());
        world.hold(1, length_m - half_edge, Eigen::Vector3d::UnitY());
        world.settle();
    }

    /// z down, y along world x, so that blades close in the world's y-z plane on a thread along x.
    static Eigen::Isometry3d frame(const Eigen::Vector3d& p_W) {
        Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
        X.linear().col(2) = -Eigen::Vector3d::UnitZ();
        X.linear().col(1) = Eigen::Vector3d::UnitX();
        X.linear().col(0) = X.linear().col(1).cross(X.linear().col(2));
        X.translation() = p_W;
        return X;
    }
};

}  // namespace atropos::sim::testing
