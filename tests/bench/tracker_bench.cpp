#include <benchmark/benchmark.h>

#include "tests/support/scalar_cost_image.hpp"
#include "tests/support/scalar_energy.hpp"
#include "tests/support/tracking_trial.hpp"
#include "tracker/label_set.hpp"
#include "tracker/stereo_cost_images.hpp"

namespace atropos {
namespace {

struct Case {
    explicit Case(int width) {
        options.seed = 5;
        options.rig = scenes::parallel_rig(width, width * 9 / 16, 575.0 / 640.0 * width, 0.005);
        drawn = support::SyntheticSequence(options).frame(0);
        frame = support::stereo_frame(drawn, 0);
    }
    support::SyntheticSequenceOptions options;
    support::SyntheticFrame drawn;
    tracker::StereoFrame frame;
};

const Case& case_of(int width) {
    static const Case small(640);
    static const Case large(1920);
    return width == 640 ? small : large;
}

void track_frame(benchmark::State& state, scenes::TrackerMethod method) {
    const Case& c = case_of(static_cast<int>(state.range(0)));
    scenes::TrackerConfig config;
    config.method = method;
    const auto tracker = tracker::make_tracker(config, c.options.rig);
    tracker->start(c.frame, tracker::fit_curve(c.drawn.truth_C, {.length_weight = 1.0}));
    for (auto _ : state) benchmark::DoNotOptimize(&tracker->track(c.frame));
}
BENCHMARK_CAPTURE(track_frame, e1, scenes::TrackerMethod::kE1)
    ->Arg(640)
    ->Arg(1920)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(track_frame, e2, scenes::TrackerMethod::kE2)
    ->Arg(640)
    ->Arg(1920)
    ->Unit(benchmark::kMillisecond);

void cost_image(benchmark::State& state) {
    const Case& c = case_of(static_cast<int>(state.range(0)));
    tracker::CostImageMaker maker(scenes::TrackerConfig{},
                                  {1.0 * static_cast<double>(state.range(0)) / 640.0},
                                  static_cast<int>(15 * state.range(0) / 640));
    for (auto _ : state)
        benchmark::DoNotOptimize(&maker.make(c.frame.left, cv::Rect({}, c.frame.left.size())));
}
BENCHMARK(cost_image)->Arg(640)->Arg(1920)->Unit(benchmark::kMillisecond);

void plain_cost_image(benchmark::State& state) {
    const Case& c = case_of(640);
    for (auto _ : state)
        benchmark::DoNotOptimize(
            support::scalar_squared_distance(support::scalar_mask(c.drawn.left, 1.0, 0.5, 8.0, 0.5), 15));
}
BENCHMARK(plain_cost_image)->Unit(benchmark::kMillisecond);

/// One step on the small case: its parts.
struct Step {
    Step()
        : c(case_of(640)),
          eyes(tracker::make_eyes(c.options.rig)),
          points(tracker::fit_curve(c.drawn.truth_C, {.length_weight = 1.0}).control_points()) {
        images.make(c.frame, pool);
        const std::vector<Eigen::Vector3d> set = tracker::label_set(3, 0.0008);
        for (int k = 0; k < 8; ++k) labels.set(k, set, eyes);
    }
    tracker::EnergyContext context() const {
        return {sampling, eyes, images.costs(), speeds, c.frame.tips, {}};
    }
    const Case& c;
    std::array<tracker::Eye, 2> eyes;
    std::vector<Eigen::Vector3d> points;
    tracker::CurveSampling sampling{3, 8, 60};
    tracker::StereoCostImages images{scenes::TrackerConfig{}, {1.0}, 15};
    scenes::WorkerPool pool{1};
    std::vector<double> speeds = std::vector<double>(60, 0.07);
    tracker::NodeLabels labels{8, 43};
    tracker::ChainProblem chain{8, 43};
};

template <typename Kind>
void potentials(benchmark::State& state) {
    Step step;
    Kind kind;
    for (auto _ : state) kind.fill(step.context(), step.points, step.labels, step.pool, step.chain);
}
BENCHMARK(potentials<tracker::PotentialsE1>)->Unit(benchmark::kMillisecond);
BENCHMARK(potentials<support::ScalarPotentialsE1>)->Unit(benchmark::kMillisecond);
BENCHMARK(potentials<tracker::PotentialsE2>)->Unit(benchmark::kMillisecond);
BENCHMARK(potentials<support::ScalarPotentialsE2>)->Unit(benchmark::kMillisecond);

void optimiser(benchmark::State& state) {
    Step step;
    tracker::PotentialsE2().fill(step.context(), step.points, step.labels, step.pool, step.chain);
    const auto dp = tracker::make_chain_optimiser(scenes::LabelOptimiser::kDynamicProgramming);
    std::vector<int> labelling(8);
    for (auto _ : state) benchmark::DoNotOptimize(dp->minimise(step.chain, labelling));
}
BENCHMARK(optimiser)->Unit(benchmark::kMillisecond);

/// What track_frame does in a frame, as the formulae say: both cost images, two steps.
template <typename Kind>
void plain_frame(benchmark::State& state) {
    Step step;
    Kind kind;
    const auto dp = tracker::make_chain_optimiser(scenes::LabelOptimiser::kDynamicProgramming);
    std::vector<int> labelling(8);
    for (auto _ : state) {
        for (const cv::Mat1b& picture : {step.c.drawn.left, step.c.drawn.right})
            benchmark::DoNotOptimize(
                support::scalar_squared_distance(support::scalar_mask(picture, 1.0, 0.5, 8.0, 0.5), 15));
        for (int i = 0; i < 2; ++i) {
            kind.fill(step.context(), step.points, step.labels, step.pool, step.chain);
            benchmark::DoNotOptimize(dp->minimise(step.chain, labelling));
        }
    }
}
BENCHMARK(plain_frame<support::ScalarPotentialsE1>)->Unit(benchmark::kMillisecond);
BENCHMARK(plain_frame<support::ScalarPotentialsE2>)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace atropos

BENCHMARK_MAIN();
