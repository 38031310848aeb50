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

    /// `tail_m` of thread hangs out of each gripper; half an edge when negative. `at_rest`, if given, is the
    /// curve to which such a thread has settled before.
    explicit HeldThread(double span_m = 0.05, double length_m = 0.07, ThreadOptions thread = {},
                        WorldOptions world_options = {}, double tail_m = -1.0,
                        const scenes::Polyline* at_rest = nullptr)
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
        const double tail = tail_m < 0.0 ? 0.5 * length_m / options.edges : tail_m;
        const double between = tail_m < 0.0 ? length_m : length_m - 2.0 * tail_m;
        scenes::Polyline curve =
            hanging_curve({X_WG[0].translation(), along}, {X_WG[1].translation(), along}, between);
        if (tail_m >= 0.0) {
            curve.points.insert(curve.points.begin(), X_WG[0].translation() - tail * along);
            curve.points.push_back(X_WG[1].translation() + tail * along);
        }
        world.add_thread(at_rest ? *at_rest : curve, options);
        world.hold(0, tail, Eigen::Vector3d::UnitY());
        world.hold(1, length_m - tail, Eigen::Vector3d::UnitY());
        if (!at_rest) world.settle();
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
