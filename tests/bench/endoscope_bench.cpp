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

void pair(benchmark::State& state, std::vector<std::string> overrides, bool at_rest = true) {
    Testbed testbed(scene(std::move(overrides)));
    EndoscopeView view(testbed, at_rest);
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

/// The tissue drawn anew in each frame, as when the camera moves.
void moving_camera(benchmark::State& state, std::vector<std::string> overrides) {
    pair(state, std::move(overrides), false);
}

/// From linear light to 8-bit pictures alone.
void sensor(benchmark::State& state, const char* preset) {
    Testbed testbed(scene({std::string("camera.preset=") + preset}));
    const View view = EndoscopeView(testbed).capture(testbed, 0);
    const render::Sensor chips(render::sensor_preset("realistic"), testbed.rig(), 1);
    int frame = 0;
    for (auto _ : state) benchmark::DoNotOptimize(chips.develop(view.truth, frame++));
}

void first_pair(benchmark::State& state) {
    const scenes::SceneConfig config = scene({});
    for (auto _ : state) {
        Testbed testbed(config);
        benchmark::DoNotOptimize(EndoscopeView(testbed).capture(testbed, 0));
    }
}

#define MEASURED(function, name, ...) \
    BENCHMARK_CAPTURE(function, name, __VA_ARGS__)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()
#define PAIR(name, ...) MEASURED(pair, name, __VA_ARGS__)
using Overrides = std::vector<std::string>;
PAIR(fast, Overrides{});
PAIR(fast_ideal_sensor, Overrides{"sensor.preset=ideal"});
PAIR(quality, Overrides{"render.preset=quality"});
PAIR(fast_1080p, Overrides{"camera.preset=hd"});
PAIR(quality_1080p, Overrides{"camera.preset=hd", "render.preset=quality"});
MEASURED(moving_camera, fast, Overrides{});
MEASURED(moving_camera, quality, Overrides{"render.preset=quality"});
MEASURED(moving_camera, fast_1080p, Overrides{"camera.preset=hd"});
MEASURED(sensor, paper, "paper");
MEASURED(sensor, hd, "hd");
BENCHMARK(first_pair)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->Iterations(3);

}  // namespace
}  // namespace atropos::experiments

BENCHMARK_MAIN();
