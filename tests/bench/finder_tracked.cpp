// The refined tracker on generated sequences of which no end is measured, started by the finder.
#include <fmt/format.h>

#include <algorithm>

#include "experiments/metrics.hpp"
#include "experiments/thread_starter.hpp"
#include "tests/bench/finder_cases.hpp"
#include "tests/support/tracking_trial.hpp"

namespace atropos::bench {

void print_tracked(const FinderTableOptions& options) {
    fmt::print(
        "\n| tracked, no end measured | frames | tracking | symmetric mean, mm | 90 % of frames within, mm | "
        "length error "
        "|\n|---|---|---|---|---|---|\n");
    for (std::uint64_t seed = static_cast<std::uint64_t>(options.first_seed);
         seed < static_cast<std::uint64_t>(options.first_seed) + 5; ++seed) {
        const support::SyntheticSequenceOptions sequence_options{.seed = seed};
        const support::SyntheticSequence sequence(sequence_options);
        scenes::TrackerConfig config;
        config.method = scenes::TrackerMethod::kRefined;
        const auto tracker = tracker::make_tracker(config, sequence_options.rig);
        experiments::ThreadStarter starter(config, sequence_options.rig);
        int tracking = 0;
        double symmetric = 0.0, length = 0.0;
        std::vector<double> all;
        for (int i = 0; i < options.frames; ++i) {
            const support::SyntheticFrame drawn = sequence.frame(i);
            tracker::StereoFrame frame = support::stereo_frame(drawn, i);
            frame.tips = {};
            const tracker::TrackResult& result = starter.track(*tracker, frame);
            if (result.estimate.status != scenes::TrackStatus::kTracking) continue;
            ++tracking;
            const experiments::FrameMetrics m = experiments::compare(
                result.estimate, visible_part(drawn.truth_C, sequence_options), sequence_options.rig);
            symmetric += m.symmetric_3d_mm;
            length += std::abs(m.length_error_percent);
            all.push_back(m.symmetric_3d_mm);
            if (options.verbose && i % 10 == 0)
                fmt::print("  {}: {:.3f} mm length {:+.2f} %\n", i, m.symmetric_3d_mm,
                           m.length_error_percent);
        }
        std::sort(all.begin(), all.end());
        fmt::print("| seed {} | {} | {} | {:.3f} | {:.3f} | {:.2f} % |\n", seed, options.frames, tracking,
                   symmetric / std::max(tracking, 1), all.empty() ? 0.0 : all[all.size() * 9 / 10],
                   length / std::max(tracking, 1));
    }
}

}  // namespace atropos::bench
