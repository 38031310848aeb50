// Converging and distorted eyes beside parallel ones of equal focal length and baseline.
#include <algorithm>
#include <cstdio>

#include "tests/bench/tracker_tables.hpp"
#include "tests/bench/trial_store.hpp"

namespace atropos::bench {

int print_rig_table(const std::string& folder, int frames) {
    constexpr double kAllowed = 1.2;
    const char* rigs[3] = {"default", "converging", "distorted"};
    support::TrialSummary found[3][2];
    for (int rig = 0; rig < 3; ++rig)
        for (std::size_t m = 0; m < 2; ++m) {
            std::vector<support::FrameScore> all;
            for (int seed = 1; seed <= 3; ++seed) {
                const Trial trial = stored_trial(folder, rigs[rig], 1, seed, frames);
                all.insert(all.end(), trial.scores[m].begin(), trial.scores[m].end());
            }
            found[rig][m] = support::summary(all);
        }
    bool met = true;
    std::printf(
        "| rig | energy | 3D mm | 2D px | failed %% | over pinhole: 3D | 2D "
        "|\n|---|---|---|---|---|---|---|\n");
    for (int rig = 0; rig < 3; ++rig)
        for (std::size_t m = 0; m < 2; ++m) {
            const support::TrialSummary &s = found[rig][m], &pinhole = found[0][m];
            const double in_3d = s.mean_3d_m / pinhole.mean_3d_m, in_2d = s.mean_2d_px / pinhole.mean_2d_px;
            met &= in_3d <= kAllowed && in_2d <= kAllowed;
            std::printf("| %s | %s | %.2f ± %.2f | %.2f ± %.2f | %.2f | %.2f | %.2f |\n",
                        rig == 0 ? "pinhole" : rigs[rig], m == 0 ? "E1" : "E2", 1e3 * s.mean_3d_m,
                        1e3 * s.std_3d_m, s.mean_2d_px, s.std_2d_px, s.failed_percent, in_3d, in_2d);
        }
    std::printf("\n- within 20 %% of the pinhole rig: %s\n", met ? "met" : "not met");
    return met ? 0 : 1;
}

}  // namespace atropos::bench
