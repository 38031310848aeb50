#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "experiments/closed_loop.hpp"
#include "experiments/commands.hpp"
#include "experiments/configured_tracker.hpp"
#include "experiments/exit_status.hpp"
#include "experiments/outside_view.hpp"
#include "experiments/overlay.hpp"
#include "experiments/picture_file.hpp"
#include "experiments/track_writer.hpp"
#include "robot/scissors_command.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace {

struct FigureOptions {
    int number = 1;
    std::string scene = "auto_scissors.yaml", output;
    double time_s = 1.0;
    CommonOptions common;
};

/// Keeps what the tracker shows of its last frame.
class Onlooker final : public tracker::TrackObserver {
  public:
    void image(std::string_view stage, int eye, const cv::Mat& picture) override {
        images[std::string(stage) + (eye == 0 ? " left" : " right")] = picture.clone();
    }
    void curve(std::string_view stage, std::span<const Eigen::Vector3d> control_points) override {
        curves[std::string(stage)] = {control_points.begin(), control_points.end()};
    }
    void node(int step, int k, int, const Eigen::Vector3d& displacement, double) override {
        if (step == 0) chosen[k] = displacement;
    }

    std::map<std::string, cv::Mat> images;
    std::map<std::string, std::vector<Eigen::Vector3d>> curves;
    std::map<int, Eigen::Vector3d> chosen;  ///< of the first step
};

/// The scene tracked for a while; its last frame in full.
struct Moment {
    std::unique_ptr<Testbed> testbed;
    View view;
    tracker::TrackResult result;
    Onlooker seen;
    scenes::Polyline truth_C;
};

std::unique_ptr<Moment> track_until(const scenes::SceneConfig& scene, double time_s) {
    auto moment = std::make_unique<Moment>();
    moment->testbed = std::make_unique<Testbed>(scene);
    Testbed& testbed = *moment->testbed;
    if (testbed.is_knotted())
        throw std::invalid_argument("arms.PSM1 holds nothing, expected the thread's start in a figure");
    EndoscopeView endoscope(testbed);
    const auto tracker = make_configured_tracker(scene.tracking.tracker, testbed.rig());
    tracker->set_observer(&moment->seen);
    const int frames = 1 + static_cast<int>(std::floor(time_s * scene.camera.fps_hz + 1e-9));
    for (int k = 0; k < frames; ++k) {
        while (testbed.time_s() < k / scene.camera.fps_hz - 5e-4) testbed.tick();
        moment->view = endoscope.capture(testbed, k);
        tracker::StereoFrame frame;
        frame.index = k;
        frame.capture_time_s = testbed.time_s();
        frame.left = moment->view.left;
        frame.right = moment->view.right;
        for (const int end : {0, 1})
            frame.tips[static_cast<size_t>(end)] =
                tracker::MeasuredTip{testbed.measured_grip_C(end), tracker::MeasuredTip::Kind::kHeld};
        moment->result = tracker->track(frame);
    }
    tracker->set_observer(nullptr);
    for (const TruthSample& s : moment->view.samples)
        if (s.in_span) moment->truth_C.points.push_back(s.p_C);
    if (moment->result.estimate.samples.empty())
        throw scenes::FileError("figure",
                                "the tracker has lost the thread at this time, expected another --time");
    return moment;
}

cv::Mat row(const std::vector<cv::Mat>& pictures) {
    cv::Mat all;
    cv::hconcat(pictures, all);
    return all;
}

cv::Mat column(const std::vector<cv::Mat>& pictures) {
    cv::Mat all;
    cv::vconcat(pictures, all);
    return all;
}

cv::Mat enlarged(const cv::Mat& picture, int zoom, int interpolation) {
    cv::Mat large;
    cv::resize(picture, large, {}, zoom, zoom, interpolation);
    return large;
}

cv::Mat outside(const Moment& moment) {
    return draw_outside_view(*moment.testbed, moment.view.samples, moment.result.estimate, {1280, 720});
}

/// Fig. 2: the curve and its control points in both pictures.
cv::Mat projection(const Moment& moment) {
    const Overlay overlay{&moment.result.estimate, moment.result.control_points, nullptr, ""};
    return draw_stereo_overlay(moment.view.left, moment.view.right, moment.testbed->rig(), overlay, 2);
}

/// Fig. 3: the label set of each node in the left picture, the chosen label marked, neighbours joined.
cv::Mat labels(const Moment& moment, const scenes::TrackerConfig& config) {
    constexpr int kZoom = 3;
    cv::Mat picture = enlarged(moment.view.left, kZoom, cv::INTER_CUBIC);
    const scenes::StereoRig& rig = moment.testbed->rig();
    const auto at = [&](const Eigen::Vector3d& p_C) {
        const Eigen::Vector2d px = rig.project_left(p_C);
        return cv::Point(static_cast<int>(std::lround(px.x() * kZoom)),
                         static_cast<int>(std::lround(px.y() * kZoom)));
    };
    const auto found = moment.seen.curves.find("before");
    const std::vector<Eigen::Vector3d>& nodes =
        found == moment.seen.curves.end() ? moment.result.control_points : found->second;
    for (size_t k = 1; k < nodes.size(); ++k)
        cv::line(picture, at(nodes[k - 1]), at(nodes[k]), {0, 200, 255}, 1, cv::LINE_AA);
    for (size_t k = 0; k < nodes.size(); ++k) {
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z) {
                    const int axes = std::abs(x) + std::abs(y) + std::abs(z);
                    if (axes != 1 && axes != 3) continue;  // axes and main diagonals of the cube (II-D3)
                    for (int step = 1; step <= config.labels.r; ++step)
                        cv::circle(picture,
                                   at(nodes[k] + step * config.labels.s_m * Eigen::Vector3d(x, y, z)), 2,
                                   {255, 255, 255}, cv::FILLED, cv::LINE_AA);
                }
        cv::circle(picture, at(nodes[k]), 5, {0, 200, 255}, 2, cv::LINE_AA);
        const auto chosen = moment.seen.chosen.find(static_cast<int>(k));
        if (chosen != moment.seen.chosen.end())
            cv::circle(picture, at(nodes[k] + chosen->second), 5, {60, 60, 255}, 2, cv::LINE_AA);
    }
    return picture;
}

/// Fig. 4: what the detector makes of both pictures.
cv::Mat detector(const Moment& moment) {
    std::vector<cv::Mat> rows = {row({moment.view.left, moment.view.right})};
    for (const char* stage : {"ridge", "cost"}) {
        std::vector<cv::Mat> eyes;
        for (const char* eye : {" left", " right"}) {
            const auto image = moment.seen.images.find(std::string(stage) + eye);
            if (image == moment.seen.images.end() || image->second.size() != moment.view.left.size())
                continue;
            cv::Mat gray, colour;
            cv::normalize(image->second, gray, 0, 255, cv::NORM_MINMAX, CV_8U);
            cv::cvtColor(gray, colour, cv::COLOR_GRAY2BGR);
            eyes.push_back(colour);
        }
        if (eyes.size() == 2) rows.push_back(row(eyes));
    }
    return column(rows);
}

/// Fig. 5: the reprojected spline, and the same moment from the side.
cv::Mat tracking(const Moment& moment) {
    const Overlay overlay{&moment.result.estimate, moment.result.control_points, nullptr, ""};
    const cv::Mat seen = draw_overlay(moment.view.left, moment.testbed->rig(), 0, overlay, 2);
    cv::Mat side;
    cv::resize(outside(moment), side, seen.size(), 0, 0, cv::INTER_AREA);
    return row({seen, side});
}

/// Fig. 6: six pictures of a cut, from the command to the end.
cv::Mat cutting(const scenes::SceneConfig& scene, bool quiet) {
    std::vector<cv::Mat> pictures;
    ClosedLoop loop(scene);
    scenes::ThreadEstimate estimate;
    loop.run([&](const LoopFrame& frame) {
        if (frame.tracked) estimate = frame.tracked->estimate;
        if (loop.testbed().time_s() < scene.cut.at_s) return;
        const robot::ScissorsState state = frame.command.state;
        const bool whole = state != robot::ScissorsState::kRetract && state != robot::ScissorsState::kDone;
        const Overlay overlay{
            whole ? &estimate : nullptr,  // of two pieces a tracker of one thread shows nothing
            {},
            nullptr,
            fmt::format("{:.2f} s  {}", loop.testbed().time_s(), robot::to_string(state))};
        pictures.push_back(draw_overlay(frame.view.left, loop.testbed().rig(), 0, overlay));
    });
    if (!quiet) fmt::print(stderr, "{} frames, {}\n", pictures.size(), loop.status().reason);
    if (pictures.size() < 6)
        throw scenes::FileError("figure 6", "the scene ends before the cut, expected a longer duration_s");
    std::vector<cv::Mat> chosen;
    for (size_t i = 0; i < 6; ++i) chosen.push_back(pictures[i * (pictures.size() - 1) / 5]);
    return column({row({chosen[0], chosen[1], chosen[2]}), row({chosen[3], chosen[4], chosen[5]})});
}

int figure(const FigureOptions& options) {
    const std::filesystem::path file = options.output;
    if (file.extension() != ".png")
        throw scenes::FileError(options.output, "no picture name, expected FILE.png");
    scenes::SceneConfig scene =
        scenes::load_scene(scenes::resolve_path("", options.scene), options.common.all_overrides());
    if (options.number == 6) {
        write_png(file, cutting(scene, options.common.quiet));
        return kDone;
    }
    if (options.number >= 2 && options.number <= 4)
        scene.tracking.tracker.method = scenes::TrackerMethod::kE2;
    scene.tracking.tracker.cost_image.region_of_interest = false;
    const std::unique_ptr<Moment> moment = track_until(scene, options.time_s);
    switch (options.number) {
        case 1:
            write_png(file, outside(*moment));
            break;
        case 2:
            write_png(file, projection(*moment));
            break;
        case 3:
            write_png(file, labels(*moment, scene.tracking.tracker));
            break;
        case 4:
            write_png(file, detector(*moment));
            break;
        default:
            write_png(file, tracking(*moment));
    }
    return kDone;
}

}  // namespace

void add_figure_command(CLI::App& program, Command& chosen) {
    CLI::App* app = program.add_subcommand("figure", "the paper's figures 1-6 from our data");
    const auto options = std::make_shared<FigureOptions>();
    app->add_option(
           "N", options->number,
           "1 arms and thread from the side, 2 curve and control points in both pictures, 3 label sets, 4 "
           "detector, 5 tracking, 6 a cut")
        ->required()
        ->check(CLI::Range(1, 6));
    app->add_option("-o,--output", options->output, "picture to write")->required()->type_name("FILE.png");
    app->add_option("--scene", options->scene, "scene file");
    app->add_option("--time", options->time_s, "of figures 1-5, s")->check(CLI::Range(0.0, 3600.0));
    add_common_options(*app, options->common);
    app->footer("Example: atropos figure 5 -o figure5.png");
    app->callback([&chosen, options] { chosen = [options] { return figure(*options); }; });
}

}  // namespace atropos::experiments
