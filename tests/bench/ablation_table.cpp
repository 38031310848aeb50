// What each choice is worth: the same frames tracked with one thing changed at a time.
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/bench/tracker_tables.hpp"
#include "tests/support/table_cases.hpp"

namespace atropos::bench {
namespace {

struct Variant {
    std::string name;
    scenes::TrackerConfig config;
};

std::vector<Variant> variants() {
    const support::TableCase c = support::table_case("default");
    std::vector<Variant> all = {{"E1", c.e1}, {"E2", c.e2}};
    const auto changed = [&all](const std::string& name, scenes::TrackerConfig config, auto&& change) {
        change(config);
        all.push_back({name, config});
    };
    changed("E1, 2D parameterisation", c.e1,
            [](auto& t) { t.parameterisation = scenes::Parameterisation::k2d; });
    changed("E2, 2D parameterisation", c.e2,
            [](auto& t) { t.parameterisation = scenes::Parameterisation::k2d; });
    changed("E2, 2D, ten times the stereo term", c.e2, [](auto& t) {
        t.parameterisation = scenes::Parameterisation::k2d;
        t.lambda_stereo *= 10.0;
    });
    changed("E1 without |l_p - l_q|", c.e1, [](auto& t) { t.lambda2_e1_per_m = 0.0; });
    changed("E1, ICM", c.e1, [](auto& t) { t.optimiser = scenes::LabelOptimiser::kIcm; });
    changed("E2, ICM", c.e2, [](auto& t) { t.optimiser = scenes::LabelOptimiser::kIcm; });
    changed("E2, labels along rays", c.e2, [](auto& t) { t.labels.shape = scenes::LabelShape::kRays; });
    changed("E2, 40 samples", c.e2, [](auto& t) { t.curve.samples = 40; });
    return all;
}

}  // namespace

int print_ablation_table(int frames) {
    const std::vector<Variant> all = variants();
    std::vector<scenes::TrackerConfig> configs;
    for (const Variant& v : all) configs.push_back(v.config);
    std::printf(
        "| accel | variant | 3D mm | 2D px | middle mm | change of its error a frame, mm | failed %% | ms a "
        "frame |\n|---|---|---|---|---|---|---|---|\n");
    for (const int accel : {1, 4}) {
        std::vector<std::vector<support::FrameScore>> scores(all.size());
        std::vector<double> middle_m(all.size()), change_m(all.size()), ms(all.size());
        for (std::uint64_t seed = 1; seed <= 3; ++seed) {
            support::SyntheticSequenceOptions options = support::table_case("default").options;
            options.seed = seed;
            options.acceleration = accel;
            const auto found = support::run_trials(configs, options, frames);
            for (std::size_t i = 0; i < all.size(); ++i) {
                for (std::size_t f = 0; f < found[i].size(); ++f) {
                    const double share = 1.0 / (3.0 * frames);
                    middle_m[i] += share * found[i][f].middle_m;
                    ms[i] += share * found[i][f].total_ms;
                    if (f > 0)
                        change_m[i] += share * std::abs(found[i][f].middle_m - found[i][f - 1].middle_m);
                }
                scores[i].insert(scores[i].end(), found[i].begin(), found[i].end());
            }
        }
        for (std::size_t i = 0; i < all.size(); ++i) {
            const support::TrialSummary s = support::summary(scores[i]);
            std::printf("| %d | %s | %.2f ± %.2f | %.2f ± %.2f | %.2f | %.2f | %.2f | %.1f |\n", accel,
                        all[i].name.c_str(), 1e3 * s.mean_3d_m, 1e3 * s.std_3d_m, s.mean_2d_px, s.std_2d_px,
                        1e3 * middle_m[i], 1e3 * change_m[i], s.failed_percent, ms[i]);
        }
    }
    return 0;
}

}  // namespace atropos::bench
