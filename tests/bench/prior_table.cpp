// What a learned prior and a rod that predicts are worth where tracking is hard.
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "experiments/prior_file.hpp"
#include "tests/bench/refined_run.hpp"
#include "tests/bench/tracker_tables.hpp"
#include "tests/support/tracking_trial.hpp"
#include "tracker/deformation_learner.hpp"
#include "tracker/refined_tracker.hpp"

namespace atropos::bench {
namespace {

constexpr SeedRange kTrainingSeeds = {101, 108};
constexpr int kTrainingFrames = 100;

/// Hard rows: those of the refined tracker's table, and faster and fainter still.
std::vector<RefinedCase> hard_cases(const std::string& wanted) {
    std::vector<RefinedCase> all;
    for (const RefinedCase& c : refined_cases())
        if (c.name == "S1" || c.name == "S5" || c.name == "fast" || c.name == "baseline" ||
            c.name == "occluded" || c.name == "faint")
            all.push_back(c);
    const auto add = [&all](const std::string& name, const std::string& words, auto&& change) {
        RefinedCase c;
        c.name = name;
        c.words = words;
        change(c);
        all.push_back(c);
    };
    add("faster", "13 times the motion, acceleration 3", [](RefinedCase& c) {
        c.options.motion_scale = 13.0;
        c.options.acceleration = 3;
    });
    add("half", "60 % hidden in 30 frames, acceleration 3", [](RefinedCase& c) {
        c.options.acceleration = 3;
        c.options.occlusion_begin = 20;
        c.options.occluded_share = 0.6;
    });
    add("faint-fast", "14 grey levels, acceleration 5", [](RefinedCase& c) {
        c.options.contrast = 14.0;
        c.options.acceleration = 5;
    });
    add("free", "one end not measured, acceleration 3", [](RefinedCase& c) {
        c.options.acceleration = 3;
        c.options.free_end = true;
    });
    std::erase_if(all, [&](const RefinedCase& c) { return c.name.rfind(wanted, 0) != 0; });
    return all;
}

/// As `atropos learn-prior` learns, from tracks of drawn sequences.
tracker::DeformationPrior learned_from_drawings() {
    tracker::DeformationLearner learner(16);
    for (std::uint64_t seed = kTrainingSeeds.first; seed <= kTrainingSeeds.last; ++seed) {
        support::SyntheticSequenceOptions options;
        options.seed = seed;
        const support::SyntheticSequence sequence(options);
        scenes::TrackerConfig config = refined_contender().config;
        config.thread.length_m = options.length_m;
        tracker::RefinedTracker tracker(config, options.rig);
        learner.begin_track();
        for (int i = 0; i < kTrainingFrames; ++i) {
            const support::SyntheticFrame drawn = sequence.frame(i);
            const tracker::StereoFrame frame = support::stereo_frame(drawn, i);
            const tracker::TrackResult& result =
                i == 0 ? tracker.start(frame, tracker::fit_curve(drawn.truth_C, {.control_points = 16,
                                                                                 .length_weight = 0.3}))
                       : tracker.track(frame);
            if (result.control_points.size() != 16) continue;
            learner.add(Eigen::Matrix3Xd::Map(result.control_points[0].data(), 3, 16), frame.capture_time_s);
        }
    }
    return learner.learn(5);
}

/// The same spread without modes: what a prior is worth that knows how far, and not how.
tracker::DeformationPrior isotropic(tracker::DeformationPrior prior) {
    const int free = 3 * (prior.control_points - 2);
    const double variance =
        (prior.sigmas_m.squaredNorm() + (free - prior.count()) * prior.rest_sigma_m * prior.rest_sigma_m) /
        free;
    prior.sigmas_m.setConstant(std::sqrt(variance));
    prior.rest_sigma_m = prior.sigmas_m[0];
    return prior;
}

std::vector<Contender> contenders(const std::vector<std::string>& files) {
    std::vector<Contender> all = {refined_contender()};
    all[0].name = "as it is";
    const auto add = [&all](const std::string& name, auto&& change) {
        all.push_back(refined_contender());
        all.back().name = name;
        change(all.back());
    };
    const tracker::DeformationPrior drawn = learned_from_drawings();
    add("learned from drawings", [&](Contender& v) { v.deformation = drawn; });
    add("as far, in any direction", [&](Contender& v) { v.deformation = isotropic(drawn); });
    add("learned from drawings, ten times the weight", [&](Contender& v) {
        v.deformation = drawn;
        v.config.refined.prior_weight = 10.0;
    });
    for (const std::string& file : files)
        add("learned: " + file.substr(file.rfind('/') + 1),
            [&](Contender& v) { v.deformation = experiments::read_deformation_prior(file); });
    add("rod", [](Contender& v) { v.config.refined.rod = true; });
    add("rod, gravity down the picture", [](Contender& v) {
        v.config.refined.rod = true;
        v.config.refined.gravity_C = Eigen::Vector3d::UnitY();
    });
    return all;
}

}  // namespace

int print_prior_table(int frames, const SeedRange& seeds, const std::string& wanted,
                      const std::vector<std::string>& files) {
    const std::vector<Contender> all = contenders(files);
    std::printf(
        "| case | variant | symmetric mm | p95 | 2D px | failed %% | events | frames to return | silent %% | "
        "within 1 / 2 sigma, depth %% | ms a frame |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (const RefinedCase& c : hard_cases(wanted)) {
        const RowRun run = run_row(c, all, {.frames = frames, .seeds = seeds});
        for (std::size_t v = 0; v < all.size(); ++v) {
            const TrackingTally& t = run.tallies[v];
            std::printf("| %s | %s | %.3f | %.2f | %.3f | %.2f | %d | %.1f | %.2f | %.0f / %.0f | %.2f |\n",
                        c.words.c_str(), all[v].name.c_str(), t.symmetric_mm.mean(),
                        t.symmetric_mm.quantile(0.95), t.error_px.mean(), t.failed_percent(), t.events,
                        t.events > 0 ? static_cast<double>(t.failed) / t.events : 0.0, t.silent_percent(),
                        t.depth_sigmas.percent_below(1.0), t.depth_sigmas.percent_below(2.0),
                        t.frame_ms.mean());
        }
        std::fflush(stdout);
    }
    std::printf("\n%d frames of each of the seeds %d to %d; drawings: seeds %d to %d.\n", frames,
                static_cast<int>(seeds.first), static_cast<int>(seeds.last),
                static_cast<int>(kTrainingSeeds.first), static_cast<int>(kTrainingSeeds.last));
    return 0;
}

}  // namespace atropos::bench
