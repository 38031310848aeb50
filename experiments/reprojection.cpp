#include "experiments/reprojection.hpp"

#include <fmt/format.h>

#include <cmath>

#include "experiments/append_file.hpp"
#include "experiments/configured_tracker.hpp"
#include "experiments/endoscope_view.hpp"
#include "experiments/output_folder.hpp"
#include "experiments/picture_file.hpp"
#include "experiments/sequence_generator.hpp"
#include "experiments/sequence_writer.hpp"
#include "scenes/calibration_file.hpp"
#include "scenes/scene_file.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
namespace {

constexpr int kCurvePoints = 501;
// Of the first tracker's labels over its steps, half of Table I's: enough for what moves 0.8 px a frame, and
// with steps so small that the jitter they leave in the spline is not most of its motion.
constexpr double kFirstReach_px = 7.0;

/// The paper's first tracker of the recorded sequence, told the exact ends.
scenes::TrackerConfig first_tracker(const Testbed& testbed) {
    scenes::TrackerConfig config;
    config.thread = testbed.scene().tracking.tracker.thread;
    config.method = scenes::TrackerMethod::kE2;
    const double z_m = 0.5 * (testbed.true_grip_C(0).z() + testbed.true_grip_C(1).z());
    config.labels.s_m = kFirstReach_px * testbed.told_rig().m_per_px(z_m) / (1.5 * config.labels.r);
    return config;
}

tracker::StereoFrame frame_with_exact_ends(const Testbed& testbed, const View& view, int index) {
    tracker::StereoFrame frame;
    frame.index = index;
    frame.capture_time_s = testbed.time_s();
    frame.left = view.left;
    frame.right = view.right;
    for (const int end : {0, 1})
        frame.tips[static_cast<size_t>(end)] =
            tracker::MeasuredTip{testbed.true_grip_C(end), tracker::MeasuredTip::Kind::kHeld};
    return frame;
}

scenes::Polyline sampled(const std::vector<Eigen::Vector3d>& control_points, int degree) {
    const tracker::NurbsCurve spline(degree, control_points);
    scenes::Polyline curve;
    for (int i = 0; i < kCurvePoints; ++i)
        curve.points.push_back(spline.point(static_cast<double>(i) / (kCurvePoints - 1)));
    return curve;
}

}  // namespace

void make_reprojected_sequence(const scenes::SceneConfig& scene, const fs::path& folder) {
    Testbed testbed(scene);
    EndoscopeView first(testbed), second(testbed);
    const scenes::TrackerConfig config = first_tracker(testbed);
    const auto tracker = make_configured_tracker(config, testbed.told_rig());
    for (const char* name : {"calib", "left", "right", "truth"}) fs::create_directories(folder / name);
    write_file(folder / "calib" / "stereo.yaml", scenes::to_opencv_yaml(testbed.told_rig()));
    write_file(folder / "scene.yaml", scenes::to_yaml(scene));
    AppendFile frames(folder / "frames.csv", "frame,time_s\n"),
        tips(folder / "tips.csv", "frame,end,kind,x_mm,y_mm,z_mm\n"),
        thread(folder / "truth" / "thread.csv", std::string(kTruthThreadColumns) + "\n");
    scenes::Polyline curve;
    for (int k = 0; k < frames_of(scene); ++k) {
        while (testbed.time_s() < k / scene.camera.fps_hz - 5e-4) testbed.tick();
        const View recorded = first.capture(testbed, k);
        const tracker::TrackResult& result = tracker->track(frame_with_exact_ends(testbed, recorded, k));
        if (!result.control_points.empty()) curve = sampled(result.control_points, config.curve.degree);
        if (curve.points.empty())
            throw std::runtime_error("the first sequence can't be tracked: nothing to re-project");
        const View view = second.capture_curve(testbed, curve, k);
        const std::string name = fmt::format("{:06d}.png", k);
        write_png(folder / "left" / name, view.left);
        write_png(folder / "right" / name, view.right);
        frames.write(fmt::format("{},{:.6f}\n", k, testbed.time_s()));
        thread.write(truth_rows(k, view.samples));
        for (const int end : {0, 1}) {
            const Eigen::Vector3d p = 1e3 * (end == 0 ? curve.points.front() : curve.points.back());
            tips.write(fmt::format("{},{},held,{:.5f},{:.5f},{:.5f}\n", k, end, p.x(), p.y(), p.z()));
        }
    }
    for (AppendFile* file : {&frames, &tips, &thread}) file->close();
}

}  // namespace atropos::experiments
