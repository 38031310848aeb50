#include "experiments/sequence_generator.hpp"

#include <cmath>

#include "experiments/endoscope_view.hpp"
#include "experiments/testbed.hpp"

namespace atropos::experiments {
namespace {

/// Ticks until frame k is due: frame times are multiples of the tick nearest to k / fps.
long ticks_of_frame(int k, double fps_hz) {
    return std::lround(1e3 * k / fps_hz);
}

}  // namespace

int frames_of(const scenes::SceneConfig& scene) {
    return static_cast<int>(std::floor(scene.duration_s * scene.camera.fps_hz + 1e-9));
}

void generate_sequence(const scenes::SceneConfig& scene, int accel, const std::filesystem::path& folder,
                       const SequenceLayers& layers, const std::function<void(int)>& advance,
                       const nlohmann::ordered_json& extra) {
    Testbed testbed(scene);
    EndoscopeView endoscope(testbed);
    SequenceWriter writer(folder, testbed, layers);
    long tick = 0;
    for (int k = 0; k < frames_of(scene); k += accel) {
        for (; tick < ticks_of_frame(k, scene.camera.fps_hz); ++tick) testbed.tick();
        writer.add(testbed, endoscope.capture(testbed, k));
        advance(accel);
    }
    nlohmann::ordered_json meta = {{"accel", accel}, {"renderer", endoscope.description()}};
    meta.update(extra);
    writer.finish(testbed, meta);
}

}  // namespace atropos::experiments
