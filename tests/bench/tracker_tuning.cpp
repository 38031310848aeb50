// Parameters by measurement, on seeds 101-103 at accelerations 1, 4 and 5.
#include <cstdio>
#include <vector>

#include "tests/bench/tracker_tables.hpp"
#include "tests/support/table_cases.hpp"
#include "tracker/label_set.hpp"

namespace atropos::bench {

int print_tuning(const std::string& camera, int frames) {
    const support::TableCase c = support::table_case(camera);
    std::vector<scenes::TrackerConfig> configs;
    for (const scenes::TrackerConfig& base : {c.e1, c.e2})
        for (const double spacing : {0.75, 1.0, 1.3})
            for (const double weight : {0.3, 1.0, 3.0}) {
                scenes::TrackerConfig config = base;
                config.labels.s_m =
                    spacing * tracker::label_spacing_m(base, c.options.rig, c.options.depth_m);
                config.labels.preset = scenes::LabelPreset::kCustom;
                (config.method == scenes::TrackerMethod::kE1 ? config.lambda1_e1 : config.lambda1_e2) *=
                    weight;
                configs.push_back(config);
            }
    std::vector<std::vector<support::FrameScore>> all(configs.size());
    for (const int accel : {1, 4, 5})
        for (std::uint64_t seed = 101; seed <= 103; ++seed) {
            support::SyntheticSequenceOptions options = c.options;
            options.seed = seed;
            options.acceleration = accel;
            const auto scores = support::run_trials(configs, options, frames);
            for (std::size_t i = 0; i < configs.size(); ++i)
                all[i].insert(all[i].end(), scores[i].begin(), scores[i].end());
        }
    std::printf(
        "| energy | s mm | lambda_1 | 3D mm | 2D px | median px | failed %% | 68 %% of offsets: px | px of "
        "disparity |\n|---|---|---|---|---|---|---|---|---|\n");
    for (std::size_t i = 0; i < configs.size(); ++i) {
        const bool first = configs[i].method == scenes::TrackerMethod::kE1;
        const support::TrialSummary s = support::summary(all[i], 5.0 * c.options.rig.left.width_px / 640.0);
        std::printf("| %s | %.3f | %.0f | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f |\n", first ? "E1" : "E2",
                    1e3 * configs[i].labels.s_m, first ? configs[i].lambda1_e1 : configs[i].lambda1_e2,
                    1e3 * s.mean_3d_m, s.mean_2d_px, s.median_2d_px, s.failed_percent,
                    offset_quantile_px(all[i], &support::FrameScore::lateral_px, 0.683),
                    offset_quantile_px(all[i], &support::FrameScore::disparity_px, 0.683));
    }
    return 0;
}

}  // namespace atropos::bench
