// CPU time of the whole process for one stereo pair with all its truth: drawing, thread, visibility, sensor.
// ATROPOS_SCENE names the scene; default scenes/auto_scissors.yaml.

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdlib>

#include "experiments/endoscope_view.hpp"
#include "scenes/scene_file.hpp"
#ifdef ATROPOS_HAS_MUJOCO
#include "tests/bench/mujoco_peer.hpp"
#endif

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

#ifdef ATROPOS_HAS_MUJOCO
/// The same meshes from another renderer: nearly all of its depths must be ours.
void mujoco(benchmark::State& state, std::vector<std::string> overrides) {
    const scenes::SceneConfig config = scene(std::move(overrides));
    Testbed testbed(config);
    const auto instruments = load_instruments(config);
    const Moment moment = testbed.moment(testbed.time_s());
    std::vector<scenes::RenderItem> items = {testbed.tissue()->item(testbed.X_WTissue())};
    for (size_t arm = 0; arm < kArms; ++arm)
        for (int link = 0; link < robot::kLinkCount; ++link)
            instruments[arm].append(link, moment.X_WL[arm][static_cast<size_t>(link)], scenes::Label::kPSM1,
                                    items);
    MujocoPeer peer(items, testbed.rig(), testbed.X_WC());
    for (auto _ : state) peer.draw();
    const View ours = EndoscopeView(testbed).capture(testbed, 0);
    int agree = 0;
    const cv::Mat& depth_m = ours.truth.left.depth_m;
    for (int y = 0; y < depth_m.rows; ++y)
        for (int x = 0; x < depth_m.cols; ++x)
            agree += std::abs(peer.depth_m(0, x, y) - depth_m.at<float>(y, x)) < 1e-4f;
    state.counters["depth_within_0.1_mm"] = agree / static_cast<double>(depth_m.total());
}
#endif

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
#ifdef ATROPOS_HAS_MUJOCO
MEASURED(mujoco, paper, Overrides{});
MEASURED(mujoco, hd, Overrides{"camera.preset=hd"});
#endif
MEASURED(sensor, paper, "paper");
MEASURED(sensor, hd, "hd");
BENCHMARK(first_pair)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->Iterations(3);

}  // namespace
}  // namespace atropos::experiments

BENCHMARK_MAIN();
