#include "experiments/recorded_run.hpp"

#include <chrono>
#include <optional>

#include "experiments/closed_loop.hpp"
#include "experiments/loop_recording.hpp"
#include "experiments/progress_meter.hpp"
#include "experiments/run_recorder.hpp"

namespace atropos::experiments {

nlohmann::ordered_json record_run(const scenes::SceneConfig& scene, const std::filesystem::path& folder,
                                  const RunRequest& request) {
    const auto start = std::chrono::steady_clock::now();
    ClosedLoop loop(scene, request.make_tracker);
    RunRecorder recorder(folder, loop, request.video);
    std::optional<LoopRecording> recording;
    if (request.record) recording.emplace(folder / "inputs", loop);
    ProgressMeter meter("run", loop.frames(), request.quiet);
    const auto each_frame = [&](const LoopFrame& frame) {
        recorder.add(frame);
        if (recording) recording->add(frame, loop.testbed().time_s());
        meter.advance();
    };
    ClosedLoop::TickObserver each_tick;
    if (recording) each_tick = [&](const LoopTick& tick) { recording->add(tick); };
    loop.run(each_frame, each_tick);
    if (recording) recording->close();
    return recorder.finish(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

}  // namespace atropos::experiments
