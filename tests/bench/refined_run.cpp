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
    config.thread.length_m = c.told_length * c.options.length_m;
    config.thread.width_m = c.options.width_m;
    if (config.method != scenes::TrackerMethod::kRefined) return tracker::make_tracker(config, told_rig(c));
    config.refined.row_sigma_px = c.row_sigma_px;
    if (c.control_points != 16) config.refined.control_points = c.control_points;
    return std::make_unique<tracker::RefinedTracker>(config, told_rig(c), contender.priors,
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

void judge_nuisances(const RefinedCase& c, const support::SyntheticFrame& drawn,
                     const tracker::TrackResult& result, RowRun& run) {
    const double length_m = drawn.truth_C.length_m();
    run.length_percent.add(100.0 * std::abs(result.estimate.length_m() / length_m - 1.0));
    const tracker::EyeCorrection error = calibration_error(c);
    const tracker::EyeCorrection found = result.eye ? result.eye->correction : tracker::EyeCorrection{};
    if (error.row_px != 0.0) run.row_share.add(std::abs(found.row_px / error.row_px - 1.0));
    if (error.roll_rad != 0.0) run.roll_share.add(std::abs(found.roll_rad / error.roll_rad - 1.0));
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
                if (t == 0 && i >= 30 && !result.estimate.samples.empty()) {
                    run.late_error_mm.add(run.tallies[0].error_mm.last());
                    judge_nuisances(c, drawn, result, run);
                }
                if (t > 0 || returned || i < clear) continue;
                returned = !failed && result.estimate.status == scenes::TrackStatus::kTracking;
                run.frames_to_return = std::max(run.frames_to_return, i - clear + (returned ? 0 : 1));
            }
        }
    }
    return run;
}

}  // namespace atropos::bench
