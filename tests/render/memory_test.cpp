#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "render/sensor.hpp"
#include "tests/render/render_scenes.hpp"

namespace atropos::render {
namespace {

using scenes::Label;

double resident_MiB() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);) {
        double kib = 0.0;
        if (line.starts_with("VmRSS:") && std::istringstream(line.substr(6)) >> kib) return kib / 1024.0;
    }
    return 0.0;
}

scenes::StereoRig small_rig() {
    scenes::StereoRig rig;
    rig.left = {160, 90, 140.0, 140.0, 79.5, 44.5, {}};
    rig.right = rig.left;
    rig.X_RC.translation().x() = -0.005;
    return rig;
}

// Everything that keeps something from frame to frame: meshes that come and go, the layer at rest under a
// camera that moves and stops, threads, samples, pictures.
TEST(StereoEndoscope, needs_no_more_memory_after_ten_thousand_frames) {
    const scenes::StereoRig rig = small_rig();
    StereoEndoscope endoscope(endoscope_preset("fast"), rig);
    const Sensor sensor(sensor_preset("realistic"), rig, 1);
    scenes::RenderItem floor = item_at(square(0.15f, 20), {0.0, 0.0, 0.11}, Label::kTissue);
    floor.at_rest = true;
    auto ball = sphere(0.008, 12);
    double early_MiB = 0.0;
    for (int frame = 1; frame <= 10000; ++frame) {
        if (frame % 20 == 0) ball = sphere(0.008 + 1e-6 * (frame % 7), 12);
        const double phase = 0.01 * frame;
        std::vector<scenes::RenderItem> items;
        items.reserve(2);
        items.push_back(floor);
        items.push_back(item_at(ball, {0.03 * std::sin(phase), 0.0, 0.1}, Label::kPSM1));
        ThreadRibbon ribbon;
        ribbon.radius_m = 1e-4;
        std::vector<SamplePoint> samples;
        for (int i = 0; i <= 40; ++i) {
            ribbon.curve_W.points.emplace_back(0.001 * i - 0.02, 0.01 * std::sin(phase + 0.1 * i), 0.09);
            samples.push_back({ribbon.curve_W.points.back(), 0, 0.001 * i});
        }
        FrameInput input;
        input.items = items;
        input.ribbons = {&ribbon, 1};
        input.samples = samples;
        if (frame % 100 < 10) input.X_WC.translation().x() = 1e-4 * (frame % 100);
        sensor.develop(endoscope.render(input), frame);
        if (frame == 1000) early_MiB = resident_MiB();
    }
    const double late_MiB = resident_MiB();
    RecordProperty("early_MiB", std::to_string(early_MiB));
    RecordProperty("late_MiB", std::to_string(late_MiB));
    EXPECT_GT(early_MiB, 0.0);
    EXPECT_LT(late_MiB, early_MiB + 2.0) << "MiB at 10,000 frames against " << early_MiB << " at 1,000";
}

}  // namespace
}  // namespace atropos::render
