// How far E1 and E2 lie from the truth on the seeds for tuning: what they state as one standard deviation.
#include <cstdio>

#include "tests/bench/tracker_tables.hpp"
#include "tests/bench/trial_store.hpp"

namespace atropos::bench {

int print_sigma_table(const std::string& camera, const std::string& folder, int frames) {
    constexpr double kOneSigma = 0.683;
    std::printf(
        "| energy | accelerations | frames | 68 %% within: px across the ray | px of disparity along it "
        "|\n|---|---|---|---|---|\n");
    for (std::size_t m = 0; m < 2; ++m) {
        const auto print = [&](const std::string& accelerations, const std::vector<support::FrameScore>& s) {
            std::printf("| %s | %s | %zu | %.3f | %.3f |\n", m == 0 ? "E1" : "E2", accelerations.c_str(),
                        s.size(), offset_quantile_px(s, &support::FrameScore::lateral_px, kOneSigma),
                        offset_quantile_px(s, &support::FrameScore::disparity_px, kOneSigma));
        };
        std::vector<support::FrameScore> all;
        for (int accel = 1; accel <= 5; ++accel) {
            std::vector<support::FrameScore> scores;
            for (int seed = 101; seed <= 103; ++seed) {
                const Trial trial = stored_trial(folder, camera, accel, seed, frames / accel);
                scores.insert(scores.end(), trial.scores[m].begin(), trial.scores[m].end());
            }
            print(std::to_string(accel), scores);
            all.insert(all.end(), scores.begin(), scores.end());
        }
        print("1-5", all);
    }
    return 0;
}

}  // namespace atropos::bench
