#include <gtest/gtest.h>

#include <cmath>

#include "experiments/endoscope_view.hpp"
#include "experiments/instrument_sights.hpp"
#include "experiments/testbed.hpp"
#include "robot/imperfection.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace {

using Eigen::Vector3d;

struct GripErrors {
    double measured_m = 0.0, lateral_m = 0.0, depth_m = 0.0;  ///< RMS: by kinematics; as seen
    double within_two_sigma = 0.0;                            ///< share of the components as seen
};

/// The grips of the default scene's two holders, calibrated arms, after half a second of pictures.
GripErrors grip_errors(int seeds) {
    GripErrors sum;
    int count = 0;
    for (int seed = 1; seed <= seeds; ++seed) {
        const scenes::SceneConfig scene =
            scenes::load_scene(ATROPOS_SCENES "/auto_scissors.yaml", {"seed=" + std::to_string(900 + seed)});
        Testbed testbed(scene);
        EndoscopeView endoscope(testbed);
        InstrumentSights sights(testbed.told_rig(), endoscope.instruments(), sight_prior(scene.arms.accuracy),
                                2);
        for (int tick = 0, frame = 0; tick <= 1000; ++tick) {
            if (tick == std::lround(1e3 * frame / 30.0)) {
                const View view = endoscope.capture(testbed, frame++);
                sights.look(view.left, view.right,
                            {read(testbed.arm(0)), read(testbed.arm(1)), read(testbed.arm(2))});
                for (int arm = 0; arm < 2 && tick >= 500; ++arm) {
                    const Vector3d p_T = testbed.arm(arm).psm().tool().X_TG.translation();
                    const Vector3d truth = testbed.true_grip_C(arm), ray = truth.normalized();
                    const Vector3d off = sights[arm].X_CT() * p_T - truth;
                    const Eigen::Matrix3d C = sights[arm].covariance(p_T);
                    sum.measured_m += (testbed.measured_grip_C(arm) - truth).squaredNorm();
                    sum.depth_m += std::pow(off.dot(ray), 2);
                    sum.lateral_m += 0.5 * (off.squaredNorm() - std::pow(off.dot(ray), 2));
                    for (int i = 0; i < 3; ++i)
                        sum.within_two_sigma += (std::abs(off[i]) < 2.0 * std::sqrt(C(i, i))) / 3.0;
                    ++count;
                }
            }
            testbed.tick();
        }
    }
    const auto rms = [&](double square) { return std::sqrt(square / count); };
    return {rms(sum.measured_m), rms(sum.lateral_m), rms(sum.depth_m), sum.within_two_sigma / count};
}

TEST(InstrumentSight, brings_the_grips_of_calibrated_arms_from_millimetres_to_tenths) {
    const GripErrors errors = grip_errors(3);
    EXPECT_GT(errors.measured_m, 0.0010);
    EXPECT_LT(errors.lateral_m, 0.0003);
    EXPECT_LT(errors.depth_m, 0.0015);
    EXPECT_GT(errors.within_two_sigma, 0.85);
}

}  // namespace
}  // namespace atropos::experiments
