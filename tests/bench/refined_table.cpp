// The refined tracker's rows, each with its bound and aim; and what its terms are worth.
#include <cstdio>
#include <string>

#include "tests/bench/refined_run.hpp"
#include "tests/bench/tracker_tables.hpp"
#include "tests/support/table_cases.hpp"

namespace atropos::bench {
namespace {

std::string figure(double value, double bound, double aim, const char* format) {
    char text[96];
    std::string out;
    std::snprintf(text, sizeof text, format, value);
    out = text;
    if (bound <= 0.0) return out;
    std::snprintf(text, sizeof text, format, bound);
    out += std::string(value <= bound ? " ≤ " : " **>** ") + text;
    if (aim <= 0.0) return out;
    std::snprintf(text, sizeof text, format, aim);
    return out + " (" + text + ")";
}

void print_row(const RefinedCase& c, const RowRun& run) {
    const TrackingTally& t = run.tallies[0];
    std::printf(
        "| %s | %s | %.2f | %s | %.2f | %s | %d | %.2f | %.2f / %.2f | %.3f | %.1f | %.0f / %.0f | %.0f / "
        "%.0f | %.0f / %.0f |\n",
        c.words.c_str(), figure(t.error_mm.mean(), c.bounds.mean_mm, c.bounds.aim_mm, "%.3f").c_str(),
        t.error_mm.quantile(0.95),
        figure(t.error_px.mean(), c.bounds.mean_px, c.bounds.aim_px, "%.3f").c_str(), run.largest_motion_px,
        figure(t.failed_percent(), c.bounds.lost_percent, 0.0, "%.2f").c_str(), t.events, t.silent_percent(),
        t.middle_mm.mean(), t.middle_mm.quantile(0.95), run.bound_mm.mean(),
        t.error_mm.mean() / run.bound_mm.mean(), t.depth_sigmas.percent_below(1.0),
        t.depth_sigmas.percent_below(2.0), t.lateral_sigmas.percent_below(1.0),
        t.lateral_sigmas.percent_below(2.0), t.along_sigmas.percent_below(1.0),
        t.along_sigmas.percent_below(2.0));
}

bool is_chosen(const RefinedCase& c, const std::string& wanted) {
    return wanted.empty() || c.name.rfind(wanted, 0) == 0;
}

bool met(bool is_met, const char* format, double a, double b = 0.0) {
    std::printf(is_met ? "- met: " : "- not met: ");
    std::printf(format, a, b);
    std::printf("\n");
    return is_met;
}

bool near(double percent, double goal, double within) {
    return percent >= goal - within && percent <= goal + within;
}

}  // namespace

int print_refined_table(int frames, const SeedRange& seeds, const std::string& wanted) {
    std::printf(
        "| case | 3D mm ≤ bound (aim) | p95 | 2D px | most px a frame | lost %% | events | silent %% | "
        "middle "
        "mean / p95 mm | Cramér-Rao mm | ratio | within 1 / 2 sigma, depth %% | lateral %% | along the "
        "thread "
        "%% |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    bool all = true;
    TrackingTally total, middle;
    Values small_ms, large_ms;
    int accelerations = 0, events = 0;
    for (const RefinedCase& c : refined_cases()) {
        if (!is_chosen(c, wanted)) continue;
        const RowRun run = run_row(c, {refined_contender()}, {.frames = frames, .seeds = seeds});
        const TrackingTally& t = run.tallies[0];
        print_row(c, run);
        std::fflush(stdout);
        all &= c.bounds.mean_mm <= 0.0 || t.error_mm.mean() <= c.bounds.mean_mm;
        all &= c.bounds.mean_px <= 0.0 || t.error_px.mean() <= c.bounds.mean_px;
        all &= c.bounds.lost_percent <= 0.0 || t.failed_percent() <= c.bounds.lost_percent;
        if (c.bounds.frames_to_return > 0)
            all &= met(run.frames_to_return <= c.bounds.frames_to_return,
                       "seen again after %.0f frames at most, bound %.0f", run.frames_to_return,
                       c.bounds.frames_to_return);
        if (c.bounds.symmetric_mm > 0.0)
            all &= met(t.symmetric_mm.mean() <= c.bounds.symmetric_mm, "symmetric mean %.3f mm, bound %.3f",
                       t.symmetric_mm.mean(), c.bounds.symmetric_mm);
        if (c.bounds.length_percent > 0.0 || c.row_sigma_px > 0.0)
            std::printf("- from frame 30 on: 3D mean %.3f mm, length %.2f %% off in the mean\n",
                        run.late_error_mm.mean(), run.length_percent.mean());
        if (c.bounds.length_percent > 0.0)
            all &= met(run.length_percent.quantile(1.0) <= c.bounds.length_percent,
                       "length %.2f %% off at most after 30 frames, bound %.1f",
                       run.length_percent.quantile(1.0), c.bounds.length_percent);
        if (c.row_offset_px > 0.0) {
            all &= met(run.row_share.mean() <= 0.2, "row offset found to %.0f %% after 30 frames, bound %.0f",
                       100.0 * run.row_share.mean(), 20.0);
            all &= met(run.roll_share.mean() <= 0.2, "roll found to %.0f %%, bound %.0f",
                       100.0 * run.roll_share.mean(), 20.0);
        }
        if (c.name[0] == 'S') {
            accelerations += t.frames;
            events += t.events;
            middle.middle_mm.add(t.middle_mm);
        }
        total.frames += t.frames;
        total.silent += t.silent;
        total.depth_sigmas.add(t.depth_sigmas);
        total.lateral_sigmas.add(t.lateral_sigmas);
        (c.options.rig.left.width_px > 640 ? large_ms : small_ms).add(t.frame_ms);
    }
    std::printf("\n%d frames of each of the seeds %d to %d.\n\n", frames, static_cast<int>(seeds.first),
                static_cast<int>(seeds.last));
    if (accelerations > 0) {
        all &= met(1e4 * events <= accelerations,
                   "%.1f losses in 10,000 frames at accelerations 1-5, bound %.0f",
                   1e4 * events / accelerations, 1.0);
        all &= met(middle.middle_mm.mean() <= 0.3, "middle of the thread there: mean %.2f mm, bound %.1f",
                   middle.middle_mm.mean(), 0.3);
        all &= met(middle.middle_mm.quantile(0.95) <= 0.7, "its 95th percentile: %.2f mm, bound %.1f",
                   middle.middle_mm.quantile(0.95), 0.7);
    }
    all &= met(total.silent_percent() <= 0.1, "silent failures over all rows: %.2f %%, bound %.1f",
               total.silent_percent(), 0.1);
    const auto covered = [&all](const char* what, const Values& sigmas) {
        std::printf(
            "- %s, over all rows: %.1f %% within one sigma, %.1f %% within two; bounds 68 ± 6 and 95 ± 3\n",
            what, sigmas.percent_below(1.0), sigmas.percent_below(2.0));
        all &= near(sigmas.percent_below(1.0), 68.0, 6.0) && near(sigmas.percent_below(2.0), 95.0, 3.0);
    };
    covered("depth", total.depth_sigmas);
    covered("lateral", total.lateral_sigmas);
    const auto timed = [&all](const Values& ms, double width_px, double frames_a_second) {
        if (!(ms.mean() > 0.0)) return;
        all &= met(1e3 / ms.mean() >= frames_a_second, "%.0f px wide: %.0f frames a second", width_px,
                   1e3 / ms.mean());
        all &= met(ms.quantile(0.99) <= 10.0, "99th percentile %.1f ms, bound %.0f", ms.quantile(0.99), 10.0);
    };
    timed(small_ms, 640.0, 300.0);
    timed(large_ms, 1920.0, 100.0);
    return all ? 0 : 1;
}

namespace {

std::vector<Contender> ablations() {
    std::vector<Contender> all = {refined_contender()};
    const auto add = [&all](const std::string& name, auto&& change) {
        Contender contender = refined_contender();
        contender.name = name;
        change(contender);
        all.push_back(contender);
    };
    add("no length per parameter", [](Contender& v) { v.priors.stretch_sigma = 1.0; });
    add("length x0.5", [](Contender& v) { v.priors.stretch_sigma *= 0.5; });
    add("length x2", [](Contender& v) { v.priors.stretch_sigma *= 2.0; });
    add("no bending",
        [](Contender& v) { v.priors.curvature_sigma_per_m = v.priors.curvature_change_sigma_per_m2 = 1e6; });
    add("curvature x0.6", [](Contender& v) { v.priors.curvature_sigma_per_m *= 0.6; });
    add("curvature x2", [](Contender& v) { v.priors.curvature_sigma_per_m *= 2.0; });
    add("its change x0.5", [](Contender& v) { v.priors.curvature_change_sigma_per_m2 *= 0.5; });
    add("its change x2", [](Contender& v) { v.priors.curvature_change_sigma_per_m2 *= 2.0; });
    add("motion within 3 mm", [](Contender& v) { v.priors.motion_sigma_m = 0.003; });
    add("ends never off", [](Contender& v) { v.config.refined.tip_bias_sigma_m = 0.0; });
    add("K = 12", [](Contender& v) { v.config.refined.control_points = 12; });
    add("K = 20", [](Contender& v) { v.config.refined.control_points = 20; });
    add("no recovery", [](Contender& v) { v.config.refined.recovery = false; });
    const support::TableCase paper = support::table_case("default");
    all.push_back({.name = "E1", .config = paper.e1});
    all.push_back({.name = "E2", .config = paper.e2});
    return all;
}

}  // namespace

int print_refined_ablation(int frames, const SeedRange& seeds, const std::string& wanted) {
    const std::vector<Contender> contenders = ablations();
    std::printf(
        "| case | variant | 3D mm | p95 | 2D px | middle mm | lost %% | silent %% | within 1 / 2 sigma, "
        "depth "
        "%% | ms a frame |\n|---|---|---|---|---|---|---|---|---|---|\n");
    for (const RefinedCase& c : refined_cases()) {
        if (!is_chosen(c, wanted)) continue;
        const RowRun run = run_row(c, contenders, {.frames = frames, .seeds = seeds});
        for (std::size_t v = 0; v < contenders.size(); ++v) {
            const TrackingTally& t = run.tallies[v];
            std::printf("| %s | %s | %.3f | %.2f | %.3f | %.2f | %.1f | %.2f | %.0f / %.0f | %.1f |\n",
                        c.name.c_str(), contenders[v].name.c_str(), t.error_mm.mean(),
                        t.error_mm.quantile(0.95), t.error_px.mean(), t.middle_mm.mean(), t.failed_percent(),
                        t.silent_percent(), t.depth_sigmas.percent_below(1.0),
                        t.depth_sigmas.percent_below(2.0), t.frame_ms.mean());
        }
        std::fflush(stdout);
    }
    return 0;
}

int print_refined_frames(int frames, const SeedRange& seeds, const std::string& wanted) {
    const auto print = [](const TrackedFrameView& seen) {
        const tracker::EyeFound eye = seen.result.eye.value_or(tracker::EyeFound{});
        std::printf(
            "%s %d %4d %.3f mm %.3f px middle %.3f mm %s eye %.3f +- %.3f px %.4f +- %.4f rad length %.3f "
            "mm\n",
            seen.row.name.c_str(), static_cast<int>(seen.row.options.seed), seen.index, seen.error_mm,
            seen.error_px, seen.middle_mm, scenes::to_string(seen.result.estimate.status),
            eye.correction.row_px, eye.sigmas().row_px, eye.correction.roll_rad, eye.sigmas().roll_rad,
            1e3 * seen.result.estimate.length_m());
    };
    for (const RefinedCase& c : refined_cases())
        if (is_chosen(c, wanted))
            run_row(c, {refined_contender()}, {.frames = frames, .seeds = seeds, .look = print});
    return 0;
}

}  // namespace atropos::bench
