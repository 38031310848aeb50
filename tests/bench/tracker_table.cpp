// Table I of the paper on generated sequences, as Markdown: E1 and E2 side by side on the same frames.
//   tracker_table PROTOCOL(P|S) CAMERA(default|A|B) FRAMES FIRST_SEED LAST_SEED
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/support/tracking_trial.hpp"

namespace {

using namespace atropos;

struct Paper {
    const char* e1_3d;
    const char* e1_2d;
    const char* e2_3d;
    const char* e2_2d;
};
constexpr Paper kPaper[5] = {{"0.47", "2.43", "0.42", "1.21"},
                             {"0.47", "2.55", "0.47", "1.12"},
                             {"0.45", "2.54", "0.52", "1.16"},
                             {"0.83", "6.77", "0.52", "1.17"},
                             {"0.84", "4.50", "0.69", "2.14"}};

void print_row(const char* energy, int accel, const support::TrialSummary& s, double m_per_disparity_px,
               const char* paper_3d, const char* paper_2d) {
    std::printf("| %d | %s | %.2f +- %.2f | %.2f +- %.2f | %.2f | %.3f | %.1f | %d | %s | %s |\n", accel,
                energy, 1e3 * s.mean_3d_m, 1e3 * s.std_3d_m, s.mean_2d_px, s.std_2d_px, s.median_2d_px,
                s.mean_3d_m / m_per_disparity_px, s.failed_percent, s.frames, paper_3d, paper_2d);
    std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 6) {
        std::fprintf(stderr,
                     "tracker_table: %d arguments, expected PROTOCOL CAMERA FRAMES FIRST_SEED LAST_SEED\n",
                     argc - 1);
        return 2;
    }
    support::SyntheticSequenceOptions options;
    options.protocol = std::string(argv[1]) == "S" ? support::Protocol::kS : support::Protocol::kP;
    const std::string camera = argv[2];
    scenes::TrackerConfig e2;
    if (camera == "A") {
        options.rig = scenes::parallel_rig(1920, 1080, 1725.0, 0.005);
        options.depth_m = 0.070;
        e2.labels.s_m = 0.0004;
    } else if (camera == "B") {
        options.depth_m = 0.220;
        e2.labels.s_m = 0.0016;
    }
    scenes::TrackerConfig e1 = e2;
    e1.method = scenes::TrackerMethod::kE1;
    const int frames = std::atoi(argv[3]);
    std::printf(
        "| accel | energy | 3D mm | 2D px | median px | disparity px | failed %% | frames | paper 3D | paper "
        "2D |\n"
        "|---|---|---|---|---|---|---|---|---|---|\n");
    for (int accel = 1; accel <= 5; ++accel) {
        options.acceleration = accel;
        std::vector<support::FrameScore> all[2];
        for (int seed = std::atoi(argv[4]); seed <= std::atoi(argv[5]); ++seed) {
            options.seed = static_cast<std::uint64_t>(seed);
            const auto scores = support::run_trials({e1, e2}, options, frames / accel);
            for (std::size_t m = 0; m < 2; ++m)
                all[m].insert(all[m].end(), scores[m].begin(), scores[m].end());
        }
        const double failure_px = 5.0 * options.rig.left.width_px / 640.0;
        const double disparity_m = options.rig.m_per_disparity_px(options.depth_m);
        const Paper& paper = kPaper[accel - 1];
        print_row("E1", accel, support::summary(all[0], failure_px), disparity_m, paper.e1_3d, paper.e1_2d);
        print_row("E2", accel, support::summary(all[1], failure_px), disparity_m, paper.e2_3d, paper.e2_2d);
    }
}
