// Threads that cross themselves, tracked through: whether the curve keeps the thread's order.
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <optional>

#include "scenes/random_stream.hpp"
#include "tests/bench/image_line.hpp"
#include "tests/bench/tracker_tables.hpp"
#include "tests/support/tracking_trial.hpp"
#include "tracker/curve_distance.hpp"
#include "tracker/refined_tracker.hpp"

namespace atropos::bench {
namespace {

constexpr double kRight_px = 8.0;         // discrete Frechet distance, in both eyes
constexpr double kLeastCrossed = 0.25;    // of a sequence's frames
constexpr double kStartError_m = 0.0005;  // of each control point, each axis
constexpr double kBound_percent = 95.0;

struct LoopCase {
    const char* words;
    bool is_long, travels;
};

ImageLine image_line(const scenes::Polyline& line, const scenes::StereoRig& rig, int eye,
                     std::size_t stride) {
    const scenes::Polyline image = tracker::image_of(line, rig, eye);
    ImageLine out;
    for (std::size_t i = 0; i < image.points.size(); i += stride) out.push_back(image.points[i].head<2>());
    return out;
}

bool is_inside(const ImageLine& line, const scenes::Camera& camera) {
    return std::all_of(line.begin(), line.end(),
                       [&](const Eigen::Vector2d& p) { return camera.contains(p); });
}

/// Nothing when the thread leaves an image, or crosses itself in too few frames.
std::optional<support::SyntheticSequenceOptions> loop_options(const LoopCase& which, std::uint64_t seed,
                                                              int frames) {
    scenes::RandomStream random(seed, "loop table");
    support::SyntheticSequenceOptions options{.seed = seed};
    if (which.is_long) options.length_m = options.depth_m = 0.150;
    options.turning_share = random.uniform(0.35, 0.6);
    options.turning_rad = which.travels ? random.uniform(4.2, 5.2) : random.uniform(3.4, 4.0);
    options.turning_swing_rad = which.travels ? 0.0 : random.uniform(1.0, 1.6);
    options.travel_share = which.travels ? random.uniform(0.10, 0.18) : 0.0;
    const support::SyntheticThread thread(options);
    int crossed = 0;
    for (int i = 0; i < frames; ++i) {
        const scenes::Polyline truth = thread.truth(i);
        const ImageLine left = image_line(truth, options.rig, 0, 4);
        if (!is_inside(left, options.rig.left) ||
            !is_inside(image_line(truth, options.rig, 1, 4), options.rig.right))
            return std::nullopt;
        crossed += self_crossings(left) > 0;
    }
    if (crossed < kLeastCrossed * frames) return std::nullopt;
    return options;
}

tracker::NurbsCurve perturbed_start(const scenes::Polyline& truth, std::uint64_t seed) {
    tracker::NurbsCurve curve = tracker::fit_curve(truth, {.control_points = 24, .length_weight = 0.3});
    std::vector<Eigen::Vector3d> points = curve.control_points();
    scenes::RandomStream random(seed, "loop start");
    for (Eigen::Vector3d& p : points)
        p += kStartError_m * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    curve.set_control_points(points);
    return curve;
}

/// Of the estimate's images from the thread's, in the worse eye.
double order_error_px(const scenes::ThreadEstimate& estimate, const scenes::Polyline& truth,
                      const scenes::StereoRig& rig) {
    scenes::Polyline found;
    for (const scenes::ThreadSample& sample : estimate.samples) found.points.push_back(sample.p_C);
    found = found.resampled(200);
    double worst = 0.0;
    for (int eye = 0; eye < 2; ++eye)
        worst = std::max(worst, frechet_px(image_line(found, rig, eye, 1), image_line(truth, rig, eye, 2)));
    return worst;
}

struct Tally {
    int sequences = 0, right_sequences = 0;
    int frames = 0, right = 0, silent = 0;
    int crossed = 0, right_crossed = 0;
    Values error_mm, off_px, frame_ms;
};

double cpu_time_ms() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

void track(const support::SyntheticSequenceOptions& options, const LoopTableOptions& table, Tally& tally) {
    scenes::TrackerConfig config = refined_contender().config;
    config.thread.length_m = options.length_m;
    config.thread.width_m = options.width_m;
    const support::SyntheticSequence sequence(options);
    tracker::RefinedTracker tracker(config, options.rig);
    int first_wrong = -1, wrong = 0;
    double worst_px = 0.0;
    for (int i = 0; i < table.frames; ++i) {
        const support::SyntheticFrame drawn = sequence.frame(i);
        const tracker::StereoFrame frame = support::stereo_frame(drawn, i);
        const double began_ms = cpu_time_ms();
        const tracker::TrackResult& result =
            i == 0 ? tracker.start(frame, perturbed_start(drawn.truth_C, options.seed))
                   : tracker.track(frame);
        tally.frame_ms.add(cpu_time_ms() - began_ms);
        const bool lost = result.estimate.samples.empty();
        const double off_px = lost ? 1e3 : order_error_px(result.estimate, drawn.truth_C, options.rig);
        const bool is_right = off_px <= kRight_px;
        const bool is_crossed = self_crossings(image_line(drawn.truth_C, options.rig, 0, 2)) > 0;
        worst_px = std::max(worst_px, off_px);
        ++tally.frames;
        tally.right += is_right;
        tally.crossed += is_crossed;
        tally.right_crossed += is_right && is_crossed;
        tally.silent += !is_right && result.estimate.status == scenes::TrackStatus::kTracking;
        wrong += !is_right;
        if (!is_right && first_wrong < 0) first_wrong = i;
        if (lost) continue;
        tally.off_px.add(off_px);
        double mm = 0.0;
        for (const scenes::ThreadSample& sample : result.estimate.samples)
            mm += 1e3 * drawn.truth_C.nearest(sample.p_C).distance_m;
        tally.error_mm.add(mm / static_cast<double>(result.estimate.samples.size()));
    }
    ++tally.sequences;
    tally.right_sequences += wrong == 0;
    if (table.verbose && wrong > 0)
        std::printf("  seed %d: %d frames wrong, the first %d, %.1f px at worst\n",
                    static_cast<int>(options.seed), wrong, first_wrong, worst_px);
}

void print_row(const char* words, const Tally& t) {
    const auto percent = [](int count, int of) { return 100.0 * count / std::max(of, 1); };
    std::printf("| %s | %d | %.1f %% | %.2f %% | %.2f %% | %.2f %% | %.2f / %.2f | %.3f / %.3f | %.1f |\n",
                words, t.sequences, percent(t.right_sequences, t.sequences), percent(t.right, t.frames),
                percent(t.right_crossed, t.crossed), percent(t.silent, t.frames), t.off_px.mean(),
                t.off_px.quantile(0.95), t.error_mm.mean(), t.error_mm.quantile(0.95),
                t.frame_ms.quantile(0.5));
    std::fflush(stdout);
}

}  // namespace

int print_loop_table(const LoopTableOptions& table) {
    std::printf(
        "| thread | sequences | right throughout | frames right | frames with a crossing right | silently "
        "wrong | "
        "Frechet px, mean / p95 | 3D mm, mean / p95 | ms |\n|---|---|---|---|---|---|---|---|---|\n");
    Tally all;
    for (const LoopCase& which : {LoopCase{"70 mm, a loop is formed and undone", false, false},
                                  LoopCase{"70 mm, a loop travels along the thread", false, true},
                                  LoopCase{"150 mm, a loop is formed and undone", true, false},
                                  LoopCase{"150 mm, a loop travels along the thread", true, true}}) {
        Tally tally;
        const int wanted = table.sequences / 4;
        for (std::uint64_t seed = table.first_seed; tally.sequences < wanted; ++seed)
            if (const auto options = loop_options(which, seed, table.frames)) track(*options, table, tally);
        print_row(which.words, tally);
        all.sequences += tally.sequences;
        all.right_sequences += tally.right_sequences;
    }
    const double right_percent = 100.0 * all.right_sequences / std::max(all.sequences, 1);
    const bool met = right_percent >= kBound_percent;
    std::printf("\n- %s: order right in every frame of %.1f %% of %d sequences, bound %.0f\n",
                met ? "met" : "MISSED", right_percent, all.sequences, kBound_percent);
    return met ? 0 : 1;
}

}  // namespace atropos::bench
