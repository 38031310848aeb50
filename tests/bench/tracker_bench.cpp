#include <benchmark/benchmark.h>

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

template <typename Kind>
void potentials(benchmark::State& state) {
    const Case& c = case_of(640);
    const std::array<tracker::Eye, 2> eyes = tracker::make_eyes(c.options.rig);
    const tracker::CurveSampling sampling(3, 8, 60);
    tracker::StereoCostImages images(scenes::TrackerConfig{}, {1.0}, 15);
    tracker::WorkerPool pool(1);
    images.make(c.frame, pool);
    const auto points = tracker::fit_curve(c.drawn.truth_C, {.length_weight = 1.0}).control_points();
    const std::vector<double> speeds(60, 0.07);
    const tracker::EnergyContext context{sampling, eyes, images.costs(), speeds, c.frame.tips, {}};
    const std::vector<Eigen::Vector3d> set = tracker::label_set(3, 0.0008);
    tracker::NodeLabels labels(8, 43);
    for (int k = 0; k < 8; ++k) labels.set(k, set, eyes);
    tracker::ChainProblem chain(8, 43);
    Kind kind;
    for (auto _ : state) kind.fill(context, points, labels, pool, chain);
}
BENCHMARK(potentials<tracker::PotentialsE1>)->Unit(benchmark::kMillisecond);
BENCHMARK(potentials<support::ScalarPotentialsE1>)->Unit(benchmark::kMillisecond);
BENCHMARK(potentials<tracker::PotentialsE2>)->Unit(benchmark::kMillisecond);
BENCHMARK(potentials<support::ScalarPotentialsE2>)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace atropos

BENCHMARK_MAIN();
