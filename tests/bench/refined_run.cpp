#include "tests/bench/refined_run.hpp"

#include <algorithm>
#include <ctime>
#include <memory>

#include "tests/support/tracking_trial.hpp"
#include "tracker/cramer_rao_bound.hpp"
#include "tracker/refined_tracker.hpp"

namespace atropos::bench {
namespace {

double cpu_time_s() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::unique_ptr<tracker::StereoTracker> tracker_of(const Contender& contender, const RefinedCase& c) {
    scenes::TrackerConfig config = contender.config;
    config.thread.length_m = c.options.length_m;
    config.thread.width_m = c.options.width_m;
    if (config.method != scenes::TrackerMethod::kRefined) return tracker::make_tracker(config, c.options.rig);
    if (c.control_points != 16) config.refined.control_points = c.control_points;
    return std::make_unique<tracker::RefinedTracker>(config, c.options.rig, contender.priors,
                                                     contender.deformation);
}

tracker::NurbsCurve start_curve(const scenes::Polyline& truth, const RefinedCase& c, bool refined) {
    const bool spline = c.options.protocol == support::Protocol::kP || !refined;
    return tracker::fit_curve(truth, {.control_points = spline ? 8 : 16,
                                      .length_weight = !refined ? 1.0
                                                       : spline ? 0.0
                                                                : 0.3});
}

/// What the bound may know is what the tracker assumes: its length, and its ends as good as they really are.
double bound_m(const RefinedCase& c, const support::SyntheticFrame& drawn) {
    tracker::BoundOptions options{.width_m = c.options.width_m,
                                  .contrast_levels = c.options.contrast,
                                  .noise_levels = c.options.noise_levels,
                                  .blur_px = c.options.blur_px,
                                  .control_points = c.control_points};
    options.tip_sigma_m = std::max(options.tip_sigma_m, 0.4 * c.options.tip_error_m);
    return tracker::cramer_rao_bound(drawn.truth_C, c.options.rig, drawn.instruments_C, options).mean_3d_m;
}

}  // namespace

Contender refined_contender() {
    Contender contender{.name = "refined", .config = {}};
    contender.config.method = scenes::TrackerMethod::kRefined;
    return contender;
}

RowRun run_row(const RefinedCase& row_case, const std::vector<Contender>& contenders,
               const RunOptions& options) {
    RowRun run;
    run.tallies.resize(contenders.size());
    for (std::uint64_t seed = options.seeds.first; seed <= options.seeds.last; ++seed) {
        RefinedCase c = row_case;
        c.options.seed = seed;
        const support::SyntheticSequence sequence(c.options);
        run.largest_motion_px =
            std::max(run.largest_motion_px, support::knot_motion(c.options, options.frames).max_2d_px);
        std::vector<std::unique_ptr<tracker::StereoTracker>> trackers;
        for (const Contender& contender : contenders) trackers.push_back(tracker_of(contender, c));
        for (TrackingTally& tally : run.tallies) tally.begin_sequence();
        const int clear = c.options.occlusion_begin + c.options.occlusion_frames;
        bool returned = c.options.occlusion_begin < 0;
        for (int i = 0; i < options.frames; ++i) {
            const support::SyntheticFrame drawn = sequence.frame(i);
            const tracker::StereoFrame frame = measured_frame(c, drawn, i);
            if (i % 10 == 0) run.bound_mm.add(1e3 * bound_m(c, drawn));
            for (std::size_t t = 0; t < trackers.size(); ++t) {
                const bool refined = contenders[t].config.method == scenes::TrackerMethod::kRefined;
                const double began_s = cpu_time_s();
                const tracker::TrackResult& result =
                    i == 0 && !c.from_tips ? trackers[t]->start(frame, start_curve(drawn.truth_C, c, refined))
                                           : trackers[t]->track(frame);
                run.tallies[t].frame_ms.add(1e3 * (cpu_time_s() - began_s));
                const bool failed = run.tallies[t].add(result.estimate, drawn.truth_C, c.options.rig);
                if (t == 0 && options.look)
                    options.look({c, i, drawn, result, run.tallies[0].error_mm.last(),
                                  run.tallies[0].error_px.last(), run.tallies[0].middle_mm.last()});
                if (t > 0 || returned || i < clear) continue;
                returned = !failed && result.estimate.status == scenes::TrackStatus::kTracking;
                run.frames_to_return = std::max(run.frames_to_return, i - clear + (returned ? 0 : 1));
            }
        }
    }
    return run;
}

}  // namespace atropos::bench
