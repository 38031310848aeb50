// Table I (III-A) on protocol P.
#include <algorithm>
#include <cstdio>
#include <string>

#include "tests/bench/tracker_tables.hpp"
#include "tests/bench/trial_store.hpp"
#include "tracker/thread_tracker.hpp"

namespace atropos::bench {
namespace {

constexpr int kSeeds = 3;

struct PaperRow {
    double motion_mean_px, motion_max_px;
    const char* e1_3d;
    const char* e1_2d;
    const char* e2_3d;
    const char* e2_2d;
};
constexpr PaperRow kPaper[5] = {{0.76, 8.10, "0.47", "2.43", "0.42", "1.21"},
                                {1.17, 8.39, "0.47", "2.55", "0.47", "1.12"},
                                {1.53, 10.37, "0.45", "2.54", "0.52", "1.16"},
                                {1.87, 13.21, "0.83", "6.77", "0.52", "1.17"},
                                {2.20, 13.80, "0.84", "4.50", "0.69", "2.14"}};

/// Both methods over the seeds of one acceleration.
struct Row {
    support::TrialSummary method[2];
    double across[2], along[2];  ///< shares of the samples within one stated sigma of the truth
    support::KnotMotion motion;
};

Row row_of(const std::string& camera, const std::string& folder, int accel, int frames) {
    Row row;
    std::vector<support::FrameScore> all[2];
    const support::TableCase c = support::table_case(camera);
    for (int seed = 1; seed <= kSeeds; ++seed) {
        const Trial trial = stored_trial(folder, camera, accel, seed, frames / accel);
        for (std::size_t m = 0; m < 2; ++m)
            all[m].insert(all[m].end(), trial.scores[m].begin(), trial.scores[m].end());
        row.motion.mean_3d_m += trial.motion.mean_3d_m / kSeeds;
        row.motion.mean_2d_px += trial.motion.mean_2d_px / kSeeds;
        row.motion.max_3d_m = std::max(row.motion.max_3d_m, trial.motion.max_3d_m);
        row.motion.max_2d_px = std::max(row.motion.max_2d_px, trial.motion.max_2d_px);
    }
    for (std::size_t m = 0; m < 2; ++m) {
        const auto stated = tracker::stated_uncertainty(m == 0 ? c.e1 : c.e2);
        row.method[m] = support::summary(all[m], 5.0 * c.options.rig.left.width_px / 640.0);
        row.across[m] = share_within(all[m], &support::FrameScore::lateral_px, stated.lateral_px);
        row.along[m] = share_within(all[m], &support::FrameScore::disparity_px, stated.disparity_px);
    }
    return row;
}

void print_method(std::size_t m, int accel, const Row& row, double m_per_disparity_px) {
    const support::TrialSummary& s = row.method[m];
    const PaperRow& paper = kPaper[accel - 1];
    std::printf(
        "| %d | %s | %.2f ± %.2f | %.2f ± %.2f | %.2f | %.3f | %.2f | %d | %d | %.0f / %.0f | %s | %s |\n",
        accel, m == 0 ? "E1" : "E2", 1e3 * s.mean_3d_m, 1e3 * s.std_3d_m, s.mean_2d_px, s.std_2d_px,
        s.median_2d_px, s.mean_3d_m / m_per_disparity_px, s.failed_percent, s.lost_frames, s.frames,
        100.0 * row.across[m], 100.0 * row.along[m], m == 0 ? paper.e1_3d : paper.e2_3d,
        m == 0 ? paper.e1_2d : paper.e2_2d);
}

bool verdict(const std::string& what, bool met) {
    std::printf("- %s: %s\n", what.c_str(), met ? "met" : "not met");
    return met;
}

std::string bounds_of(double worst, const char* what, double bound, const char* unit) {
    char text[160];
    std::snprintf(text, sizeof text, "%s %.2f %s, bound %.2f", what, worst, unit, bound);
    return text;
}

/// The bounds of the camera, one line each; whether all are met.
bool print_verdicts(const std::string& camera, const Row* rows) {
    bool met = true;
    double e2_px = 0.0, e2_lost = 0.0, e1_median = 0.0, e2_mm = 0.0, motion = 0.0, motion_max = 0.0;
    for (int i = 0; i < 5; ++i) {
        const support::TrialSummary &e1 = rows[i].method[0], &e2 = rows[i].method[1];
        e2_mm = std::max(e2_mm, 1e3 * e2.mean_3d_m);
        motion = std::max(motion, std::abs(rows[i].motion.mean_2d_px / kPaper[i].motion_mean_px - 1.0));
        motion_max = std::max(motion_max, std::abs(rows[i].motion.max_2d_px / kPaper[i].motion_max_px - 1.0));
        if (i == 4) continue;
        e2_px = std::max(e2_px, e2.mean_2d_px);
        e2_lost = std::max(e2_lost, e2.failed_percent);
        e1_median = std::max(e1_median, e1.median_2d_px);
    }
    met &= verdict(bounds_of(100.0 * motion, "mean image motion off Table I's by at most", 20.0, "%"),
                   motion <= 0.2);
    met &= verdict(bounds_of(100.0 * motion_max, "largest image motion off Table I's by at most", 20.0, "%"),
                   motion_max <= 0.2);
    if (camera == "default") {
        met &= verdict(bounds_of(e2_px, "E2, 2D mean at 1-4: at most", 0.8, "px"), e2_px <= 0.8);
        met &= verdict(bounds_of(e2_lost, "E2, lost at 1-4: at most", 1.0, "%"), e2_lost <= 1.0);
        met &= verdict(bounds_of(e1_median, "E1, median over frames at 1-4: at most", 1.3, "px"),
                       e1_median <= 1.3);
    }
    if (camera == "B") met &= verdict(bounds_of(e2_mm, "E2, 3D mean: at most", 4.2, "mm"), e2_mm <= 4.2);
    return met;
}

/// The shares within one stated sigma over the frames of all accelerations.
void print_coverage(const Row* rows) {
    for (std::size_t m = 0; m < 2; ++m) {
        double across = 0.0, along = 0.0, frames = 0.0;
        for (int i = 0; i < 5; ++i) {
            const double tracked = rows[i].method[m].frames - rows[i].method[m].lost_frames;
            across += tracked * rows[i].across[m];
            along += tracked * rows[i].along[m];
            frames += tracked;
        }
        std::printf("- %s, within one sigma over all frames: %.0f %% across the ray, %.0f %% along it\n",
                    m == 0 ? "E1" : "E2", 100.0 * across / frames, 100.0 * along / frames);
    }
}

}  // namespace

int print_paper_table(const std::string& camera, const std::string& folder, int frames) {
    const support::TableCase c = support::table_case(camera);
    Row rows[5];
    for (int accel = 1; accel <= 5; ++accel) rows[accel - 1] = row_of(camera, folder, accel, frames);
    std::printf(
        "Camera %s: %dx%d, f %.0f px, baseline 5 mm, thread at %.0f mm, %.2f mm per px of disparity; %d "
        "seeds.\n\n",
        camera.c_str(), c.options.rig.left.width_px, c.options.rig.left.height_px, c.options.rig.left.fx_px,
        1e3 * c.options.depth_m, 1e3 * c.options.rig.m_per_disparity_px(c.options.depth_m), kSeeds);
    std::printf("| accel | motion mean / max, px | Table I | motion mean / max, mm |\n|---|---|---|---|\n");
    for (int i = 0; i < 5; ++i)
        std::printf("| %d | %.2f / %.2f | %.2f / %.2f | %.3f / %.2f |\n", i + 1, rows[i].motion.mean_2d_px,
                    rows[i].motion.max_2d_px, kPaper[i].motion_mean_px, kPaper[i].motion_max_px,
                    1e3 * rows[i].motion.mean_3d_m, 1e3 * rows[i].motion.max_3d_m);
    std::printf(
        "\n| accel | energy | 3D mm | 2D px | median px | 3D in px of disparity | failed %% | lost | frames "
        "| within 1 sigma "
        "across / along the ray %% | paper 3D | paper 2D "
        "|\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (int i = 0; i < 5; ++i) {
        const double disparity_m = c.options.rig.m_per_disparity_px(c.options.depth_m);
        for (std::size_t m = 0; m < 2; ++m) print_method(m, i + 1, rows[i], disparity_m);
    }
    std::printf("\n");
    print_coverage(rows);
    return print_verdicts(camera, rows) ? 0 : 1;
}

}  // namespace atropos::bench
