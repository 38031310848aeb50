// The finder on frames of the endoscope: tissue, gloss, sensor noise and all.
#include <fmt/format.h>

#include "experiments/endoscope_view.hpp"
#include "scenes/random_stream.hpp"
#include "scenes/scene_file.hpp"
#include "tests/bench/finder_frames.hpp"

namespace atropos::bench {
namespace {

/// Ground, thread and distance as the seed has them; the rest as in the default scene.
scenes::SceneConfig varied_scene(std::uint64_t seed, const char* tissue) {
    scenes::RandomStream random(seed, "finder table, rendered");
    const auto set = [](const char* key, auto value) { return fmt::format("{}={}", key, value); };
    return scenes::load_scene(
        ATROPOS_SCENES "/auto_scissors.yaml",
        {set("seed", seed), set("tissue.preset", tissue), set("tissue.depth_mm", random.uniform(30.0, 40.0)),
         set("thread.diameter_mm", random.uniform(0.22, 0.35)), set("thread.colour", "black"),
         set("camera.working_distance_mm", random.uniform(95.0, 115.0)), set("tracker.tips", "none")});
}

tracker::StereoFrame frame_of(const experiments::View& view) {
    tracker::StereoFrame frame;
    frame.left = view.left;
    frame.right = view.right;
    return frame;
}

/// Whether the thread differs from the ground behind it everywhere: least mean over 20 px in either eye, in
/// grey levels of the channel that is looked at. Sensor noise is about 4.
constexpr double kLeastDifference_levels = 10.0;

bool stands_out(const FinderFrame& drawn, const experiments::View& without) {
    for (const std::size_t eye : {0, 1}) {
        const cv::Mat& with_thread = eye == 0 ? drawn.frame.left : drawn.frame.right;
        const cv::Mat& ground = eye == 0 ? without.left : without.right;
        const ImageLine& line = drawn.visible_px[eye];  // points 1 px apart or less
        std::vector<double> difference;
        for (const Eigen::Vector2d& p : line) {
            const cv::Point at(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())));
            difference.push_back(ground.at<cv::Vec3b>(at)[2] - with_thread.at<cv::Vec3b>(at)[2]);
        }
        constexpr std::size_t kWindow = 20;
        double sum = 0.0;
        for (std::size_t i = 0; i < difference.size(); ++i) {
            sum += difference[i];
            if (i >= kWindow) sum -= difference[i - kWindow];
            if (i + 1 >= kWindow && sum < kWindow * kLeastDifference_levels) return false;
        }
    }
    return true;
}

/// A thread of which both ends lie free, over tissue; nothing where some of it is out of sight.
std::optional<FinderFrame> free_thread(std::uint64_t seed, const char* tissue, int crossings) {
    const scenes::SceneConfig scene = varied_scene(seed, tissue);
    support::SyntheticSequenceOptions options = finder_sequence(seed, crossings);
    options.rig = experiments::told_rig(scene);  // the true one: no calibration error here
    options.depth_m = scene.camera.working_distance_m;
    FinderFrame drawn{.rig = options.rig,
                      .config = scene.tracking.tracker,
                      .frame = {},
                      .visible_C = support::SyntheticThread(options).truth(0)};
    drawn.visible_px = images_of(drawn.visible_C, drawn.rig);
    if (!is_whole(drawn.visible_px, drawn.rig, crossings)) return std::nullopt;
    const experiments::Testbed testbed(scene);
    experiments::EndoscopeView endoscope(testbed);
    const experiments::View view = endoscope.capture_curve(testbed, drawn.visible_C, 0);
    for (const experiments::TruthSample& sample : view.samples)
        if (!sample.visible[0] || !sample.visible[1]) return std::nullopt;
    drawn.frame = frame_of(view);
    scenes::Polyline away = drawn.visible_C;
    for (Eigen::Vector3d& p : away.points) p.x() += 1.0;
    if (!stands_out(drawn, endoscope.capture_curve(testbed, away, 0))) return std::nullopt;
    return drawn;
}

FinderCase free_case(const char* name, const char* tissue, int crossings) {
    return {name, [=](std::uint64_t seed) { return free_thread(seed, tissue, crossings); }};
}

}  // namespace

void print_rendered(const FinderTableOptions& options) {
    print_cases(options, {free_case("rendered, no crossing, organ", "organ", 0),
                          free_case("rendered, one crossing, organ", "organ", 1)});
}

void print_on_pad(const FinderTableOptions& options) {
    print_cases(options, {free_case("rendered, no crossing, training pad", "pad", 0),
                          free_case("rendered, one crossing, training pad", "pad", 1)});
}

}  // namespace atropos::bench
