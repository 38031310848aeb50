// Where images put instruments that kinematics measure millimetres off, on rendered pictures.
//   instrument_table [SEEDS]   two holders a seed; the default scene, calibrated arms, as Markdown
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "experiments/endoscope_view.hpp"
#include "experiments/instrument_sights.hpp"
#include "experiments/testbed.hpp"
#include "robot/imperfection.hpp"
#include "scenes/scene_file.hpp"
#include "tracker/instrument_offset.hpp"

namespace atropos::bench {
namespace {

using Eigen::Vector3d;
constexpr int kPictures = 10;  // that the sight has had

/// Errors of grips, with what is stated of them.
struct Errors {
    int count = 0, within_one = 0, within_two = 0;
    double lateral = 0.0, depth = 0.0;  ///< sums of squares, m^2; lateral of one axis

    void add(const Vector3d& off, const Vector3d& truth, const Eigen::Matrix3d& covariance) {
        const double along = off.dot(truth.normalized());
        depth += along * along;
        lateral += 0.5 * (off.squaredNorm() - along * along);
        for (int i = 0; i < 3; ++i) {
            const double sigmas = std::abs(off[i]) / std::sqrt(covariance(i, i));
            within_one += sigmas < 1.0;
            within_two += sigmas < 2.0;
        }
        ++count;
    }
    void print(const char* name) const {
        const double n = std::max(count, 1);
        std::printf("| %s | %d | %.2f | %.2f | %.0f / %.0f |\n", name, count, 1e3 * std::sqrt(lateral / n),
                    1e3 * std::sqrt(depth / n), 100.0 * within_one / (3.0 * n),
                    100.0 * within_two / (3.0 * n));
    }
};

struct Rows {
    Errors measured, outline, sight;
};

void add_seed(int seed, Rows& rows) {
    using namespace experiments;
    const scenes::SceneConfig scene =
        scenes::load_scene(ATROPOS_SCENES "/auto_scissors.yaml", {"seed=" + std::to_string(seed)});
    Testbed testbed(scene);
    EndoscopeView endoscope(testbed);
    InstrumentSights sights(testbed.told_rig(), endoscope.instruments(), sight_prior(scene.arms.accuracy), 1);
    for (int tick = 0, picture = 0; picture < kPictures; ++tick) {
        if (tick == std::lround(1e3 * picture / 30.0)) {
            const View view = endoscope.capture(testbed, picture++);
            const std::array<ArmReading, kArms> arms = {read(testbed.arm(0)), read(testbed.arm(1)),
                                                        read(testbed.arm(2))};
            sights.look(view.left, view.right, arms);
            if (picture < kPictures) continue;
            tracker::StereoFrame frame;
            frame.left = view.left;
            frame.right = view.right;
            for (int arm = 0; arm < 2; ++arm) {
                const Vector3d truth = testbed.true_grip_C(arm), off = testbed.measured_grip_C(arm) - truth;
                rows.measured.add(off, truth, std::pow(0.0011, 2) * Eigen::Matrix3d::Identity());
                const auto found = tracker::find_instrument_offset(
                    frame, testbed.told_rig(), arms[static_cast<std::size_t>(arm)].capsules_C(),
                    arms[static_cast<std::size_t>(1 - arm)].capsules_C());
                if (found.found) rows.outline.add(off + found.offset_C, truth, found.covariance);
                const Vector3d p_T = testbed.arm(arm).psm().tool().X_TG.translation();
                rows.sight.add(sights[arm].X_CT() * p_T - truth, truth, sights[arm].covariance(p_T));
            }
        }
        testbed.tick();
    }
}

}  // namespace
}  // namespace atropos::bench

int main(int argc, char** argv) {
    atropos::bench::Rows rows;
    const int seeds = argc > 1 ? std::atoi(argv[1]) : 100;
    for (int seed = 1; seed <= seeds; ++seed) atropos::bench::add_seed(2000 + seed, rows);
    std::printf(
        "| grips by | found | lateral mm, one axis | depth mm | within 1 / 2 sigma, %% "
        "|\n|---|---|---|---|---|\n");
    rows.measured.print("kinematics; sigma 1.1 mm");
    rows.outline.print("`tracker/instrument_offset`, one picture");
    rows.sight.print("`experiments/instrument_sight`, ten pictures");
}
