// CPU time of the whole process for one stereo pair with all its truth: drawing, thread, visibility, sensor.
// ATROPOS_SCENE names the scene; default scenes/auto_scissors.yaml.

#include <benchmark/benchmark.h>

#include <cstdlib>

#include "experiments/endoscope_view.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace {

scenes::SceneConfig scene(std::vector<std::string> overrides) {
    const char* file = std::getenv("ATROPOS_SCENE");
    return scenes::load_scene(file ? file : ATROPOS_SCENES "/auto_scissors.yaml", overrides);
}

void pair(benchmark::State& state, std::vector<std::string> overrides) {
    Testbed testbed(scene(std::move(overrides)));
    EndoscopeView view(testbed);
    int frame = 0;
    view.capture(testbed, frame++);
    for (auto _ : state) {
        state.PauseTiming();
        for (int k = 0; k < 33; ++k) testbed.tick();
        state.ResumeTiming();
        benchmark::DoNotOptimize(view.capture(testbed, frame++));
    }
    state.SetLabel(view.description());
}

void first_pair(benchmark::State& state) {
    const scenes::SceneConfig config = scene({});
    for (auto _ : state) {
        Testbed testbed(config);
        benchmark::DoNotOptimize(EndoscopeView(testbed).capture(testbed, 0));
    }
}

#define PAIR(name, ...) \
    BENCHMARK_CAPTURE(pair, name, __VA_ARGS__)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()
using Overrides = std::vector<std::string>;
PAIR(fast, Overrides{});
PAIR(fast_ideal_sensor, Overrides{"sensor.preset=ideal"});
PAIR(quality, Overrides{"render.preset=quality"});
PAIR(fast_1080p, Overrides{"camera.preset=hd"});
PAIR(quality_1080p, Overrides{"camera.preset=hd", "render.preset=quality"});
BENCHMARK(first_pair)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->Iterations(3);

}  // namespace
}  // namespace atropos::experiments

BENCHMARK_MAIN();
