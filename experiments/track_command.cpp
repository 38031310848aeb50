#include <fmt/format.h>

#include <fstream>
#include <memory>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "experiments/commands.hpp"
#include "experiments/configured_tracker.hpp"
#include "experiments/exit_status.hpp"
#include "experiments/explain.hpp"
#include "experiments/external_tracker.hpp"
#include "experiments/knot_ends.hpp"
#include "experiments/output_folder.hpp"
#include "experiments/overlay.hpp"
#include "experiments/picture_file.hpp"
#include "experiments/progress_meter.hpp"
#include "experiments/sequence_arms.hpp"
#include "experiments/thread_starter.hpp"
#include "experiments/track_writer.hpp"
#include "experiments/version.hpp"
#include "experiments/video_writer.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using scenes::FileError;
namespace {

struct TrackOptions {
    std::string sequence, output, method, config;
    bool overlay = false;
    int explain = -1;
    ExternalTrackerOptions external;
    std::vector<double> seed_point;  ///< u, v in the left image, px; empty = none
    CommonOptions common;
};

/// The tracker's settings: --config, else the sequence's scene.yaml, else the defaults; then --method and
/// --set.
scenes::SceneConfig settings(const TrackOptions& options) {
    std::vector<std::string> overrides = options.common.overrides;
    if (!options.method.empty()) overrides.insert(overrides.begin(), "tracker.method=" + options.method);
    fs::path file = options.config;
    if (file.empty() && fs::exists(fs::path(options.sequence) / "scene.yaml"))
        file = fs::path(options.sequence) / "scene.yaml";
    scenes::SceneConfig scene = file.empty() ? scenes::parse_scene("settings", "{}\n", ".", overrides)
                                             : scenes::load_scene(file, overrides);
    scene.tracking.tracker.threads = options.common.threads;
    return scene;
}

const char* method_name(scenes::TrackerMethod method) {
    return method == scenes::TrackerMethod::kE1   ? "e1"
           : method == scenes::TrackerMethod::kE2 ? "e2"
                                                  : "refined";
}

nlohmann::ordered_json track_meta(const Sequence& sequence, const scenes::SceneConfig& scene,
                                  const std::string& command) {
    nlohmann::ordered_json meta;
    meta["sequence"] = fs::weakly_canonical(sequence.folder()).filename().string();
    meta["frames"] = sequence.frames();
    meta["method"] = command.empty() ? method_name(scene.tracking.tracker.method) : "external";
    if (!command.empty()) meta["command"] = command;
    meta["version"] = version_number();
    // The whole settings: the section `tracker` of the resolved scene.
    const std::string text = scenes::to_yaml(scene);
    const std::size_t begin = text.find("tracker:"), end = text.find("\ncut:");
    meta["configuration"] = text.substr(begin, end - begin);
    return meta;
}

/// Throws FileError when it is no pixel of the left picture.
std::optional<Eigen::Vector2d> seed_point(const TrackOptions& options, const scenes::Camera& left) {
    if (options.seed_point.size() != 2) return std::nullopt;
    const Eigen::Vector2d p(options.seed_point[0], options.seed_point[1]);
    if (!(p.x() >= 0.0 && p.x() < left.width_px && p.y() >= 0.0 && p.y() < left.height_px))
        throw FileError("--seed-point",
                        fmt::format("{},{} lies outside the left picture, expected 0,0 to {},{}", p.x(),
                                    p.y(), left.width_px - 1, left.height_px - 1));
    return p;
}

/// What the tracker found that was given wrongly, or not for certain: with one sigma, into `meta` and to the
/// user.
void report_found(const tracker::TrackResult& last, double given_length_m, bool quiet,
                  nlohmann::ordered_json& meta) {
    if (last.eye) {
        constexpr double kDegrees = 180.0 / std::numbers::pi;
        const tracker::EyeCorrection found = last.eye->correction, sigma = last.eye->sigmas();
        meta["calibration"] = {{"right_row_offset_px", found.row_px},
                               {"right_row_offset_sigma_px", sigma.row_px},
                               {"right_roll_deg", kDegrees * found.roll_rad},
                               {"right_roll_sigma_deg", kDegrees * sigma.roll_rad}};
        if (!quiet)
            fmt::print(stderr,
                       "right eye: rows off by {:.3f} +- {:.3f} px, roll by {:.3f} +- {:.3f} degrees\n",
                       found.row_px, sigma.row_px, kDegrees * found.roll_rad, kDegrees * sigma.roll_rad);
    }
    if (last.length_refuted) {
        const double found_mm = 1e3 * last.estimate.length_m();
        meta["length"] = {{"given_mm", 1e3 * given_length_m}, {"found_mm", found_mm}};
        if (!quiet)
            fmt::print(stderr, "length: {:.1f} mm was given, {:.1f} mm is seen\n", 1e3 * given_length_m,
                       found_mm);
    }
}

void print_labels(const scenes::TrackerConfig& config, bool quiet) {
    if (quiet || config.method == scenes::TrackerMethod::kRefined) return;
    fmt::print(stderr, "labels: r {}, s {:.4g} mm, {} steps, {} labels a node\n", config.labels.r,
               1e3 * config.labels.s_m, config.labels.steps, 14 * config.labels.r + 1);
}

int track(const TrackOptions& options) {
    check_output(options.output, options.common.force);
    const Sequence sequence = Sequence::open(options.sequence);
    const scenes::SceneConfig scene = settings(options);
    const bool external = !options.external.command.empty();
    if (external && options.explain >= 0)
        throw FileError("--explain", "looks into our own trackers only, not into --tracker");
    std::string log;
    const std::unique_ptr<tracker::StereoTracker> tracker =
        external ? make_external_tracker(options.external, sequence.rig(), log, options.common.quiet)
                 : make_configured_tracker(scene.tracking.tracker, sequence.rig());
    const bool refined = !external && scene.tracking.tracker.method == scenes::TrackerMethod::kRefined;
    const std::unique_ptr<SequenceArms> arms =  // the paper's trackers know no instruments
        refined ? SequenceArms::open(sequence, sequence.rig(), options.common.threads) : nullptr;
    const std::optional<Eigen::Vector2d> seed_px = seed_point(options, sequence.rig().left);
    ThreadStarter starter(scene.tracking.tracker, sequence.rig(), seed_px);
    if (options.explain >= sequence.frames())
        throw FileError("--explain", fmt::format("{} is beyond the last frame, {}", options.explain,
                                                 sequence.frames() - 1));
    OutputFolder output(options.output, options.common.force);
    if (!external) print_labels(scene.tracking.tracker, options.common.quiet);

    TrackWriter writer;
    std::unique_ptr<VideoWriter> video;
    const int frames = options.explain >= 0 ? options.explain + 1 : sequence.frames();
    ProgressMeter meter("track", frames, options.common.quiet);
    tracker::TrackerState before;
    KnotEnds knots;
    tracker::StereoFrame frame;
    tracker::TrackResult last;
    for (int i = 0; i < frames; ++i) {
        frame = sequence.frame(i);
        if (arms) arms->add_to(frame, i);
        knots.place(frame);
        before = tracker->state();
        // Other people's trackers start themselves.
        const tracker::TrackResult& result =
            external ? tracker->track(frame) : starter.track(*tracker, frame);
        knots.learn(frame, result.estimate);
        writer.add(result);
        if (!result.estimate.samples.empty()) last = result;
        writer.add_state(tracker->state());
        writer.add_timings(tracker->timings());
        if (options.overlay) {
            Overlay overlay{&result.estimate, result.control_points, nullptr,
                            fmt::format("{:06d} {}", i, scenes::to_string(result.estimate.status))};
            const cv::Mat picture = draw_stereo_overlay(frame.left, frame.right, sequence.rig(), overlay);
            fs::create_directories(output.path() / "overlay");
            write_png(output.path() / "overlay" / fmt::format("{:06d}.png", i), picture);
            const double fps = sequence.frames() > 1 ? 1.0 / (sequence.time_s(1) - sequence.time_s(0)) : 30.0;
            if (!video)
                video = std::make_unique<VideoWriter>(output.path() / "overlay.mp4", picture.size(), fps);
            video->add(picture);
        }
        meter.advance();
    }
    if (video) video->close();
    if (options.explain >= 0) explain_frame(*tracker, before, sequence, frame, output.path() / "explain");
    nlohmann::ordered_json meta = track_meta(sequence, scene, options.external.command);
    report_found(last, scene.tracking.tracker.thread.length_m, options.common.quiet, meta);
    writer.write(output.path(), meta);
    if (external) write_file(output.path() / "tracker.log", log);
    output.commit();
    return kDone;
}

}  // namespace

void add_track_command(CLI::App& program, Command& chosen) {
    CLI::App* app = program.add_subcommand("track", "tracks the thread in a recorded or generated sequence");
    const auto options = std::make_shared<TrackOptions>();
    app->add_option("SEQUENCE", options->sequence, "folder with calib/stereo.yaml, left/, right/")
        ->required();
    app->add_option("-o,--output", options->output, "folder of the track")->required();
    app->add_option("--method", options->method, "e1, e2: the paper's; refined: to the images' limit")
        ->check(CLI::IsMember({"e1", "e2", "refined"}));
    app->add_option("--config", options->config,
                    "scene file whose `tracker` section to use (default: the sequence's scene.yaml)");
    app->add_flag("--overlay", options->overlay, "pictures with the curve drawn in, and overlay.mp4");
    app->add_option("--explain", options->explain, "write every step of this frame as pictures and tables")
        ->type_name("FRAME");
    add_external_tracker_options(*app, options->external);
    app->add_option("--seed-point", options->seed_point,
                    "a point of the thread in the first left picture, where no ends are measured")
        ->type_name("U,V")
        ->delimiter(',')
        ->expected(2);
    add_common_options(*app, options->common);
    app->footer("Example: atropos track results/data/sequence_000000 -o results/track --method e2 --overlay");
    app->callback([&chosen, options] { chosen = [options] { return track(*options); }; });
}

}  // namespace atropos::experiments
