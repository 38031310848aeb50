#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "experiments/commands.hpp"
#include "experiments/endoscope_view.hpp"
#include "experiments/exit_status.hpp"
#include "experiments/picture_file.hpp"
#include "experiments/testbed.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
namespace {

struct RenderOptions {
    std::string scene, output;
    double time_s = 0.0;
    bool layers = false;
    CommonOptions common;
};

cv::Mat side_by_side(const cv::Mat& left, const cv::Mat& right) {
    cv::Mat both;
    cv::hconcat(left, right, both);
    return both;
}

/// Labels as colours, depth from near (bright) to far, so that a person can look at them.
cv::Mat label_colours(const cv::Mat& labels) {
    static const cv::Vec3b colours[] = {{0, 0, 0},      {255, 255, 255}, {80, 80, 160},  {60, 200, 60},
                                        {200, 120, 40}, {40, 200, 220},  {200, 60, 200}, {120, 120, 120}};
    cv::Mat picture(labels.size(), CV_8UC3);
    for (int y = 0; y < labels.rows; ++y)
        for (int x = 0; x < labels.cols; ++x)
            picture.at<cv::Vec3b>(y, x) = colours[std::min<int>(labels.at<uchar>(y, x), 7)];
    return picture;
}

cv::Mat depth_shades(const cv::Mat& depth_m) {
    cv::Mat shades(depth_m.size(), CV_8U);
    double far = 0.0;
    cv::minMaxLoc(depth_m, nullptr, &far);
    for (int y = 0; y < depth_m.rows; ++y)
        for (int x = 0; x < depth_m.cols; ++x) {
            const float d = depth_m.at<float>(y, x);
            shades.at<uchar>(y, x) =
                d > 0.0f ? cv::saturate_cast<uchar>(255.0 * (1.0 - d / (1.1 * far))) : uchar{0};
        }
    return shades;
}

int render(const RenderOptions& options) {
    const fs::path file = options.output;
    if (file.extension() != ".png")
        throw scenes::FileError(options.output, "no picture name, expected FILE.png");
    const scenes::SceneConfig scene = scenes::load_scene(options.scene, options.common.all_overrides());
    Testbed testbed(scene);
    EndoscopeView endoscope(testbed);
    const long ticks = std::lround(1e3 * options.time_s);
    for (long i = 0; i < ticks; ++i) testbed.tick();
    const View view =
        endoscope.capture(testbed, static_cast<int>(std::lround(options.time_s * scene.camera.fps_hz)));
    write_png(file, side_by_side(view.left, view.right));
    if (options.layers) {
        const auto beside = [&](const char* layer) {
            return file.parent_path() / (file.stem().string() + "_" + layer + ".png");
        };
        const auto &l = view.truth.left, &r = view.truth.right;
        write_png(beside("labels"), side_by_side(label_colours(l.labels), label_colours(r.labels)));
        write_png(beside("depth"), side_by_side(depth_shades(l.depth_m), depth_shades(r.depth_m)));
        cv::Mat coverage;
        side_by_side(l.coverage, r.coverage).convertTo(coverage, CV_8U, 255.0);
        write_png(beside("coverage"), coverage);
    }
    return kDone;
}

}  // namespace

void add_render_command(CLI::App& program, Command& chosen) {
    CLI::App* app = program.add_subcommand("render", "a still stereo pair of a scene, side by side");
    const auto options = std::make_shared<RenderOptions>();
    app->add_option("SCENE", options->scene, "scene file")->required();
    app->add_option("-o,--output", options->output, "FILE.png")->required();
    app->add_option("--time", options->time_s, "simulated time, s")->check(CLI::Range(0.0, 3600.0));
    app->add_flag("--layers", options->layers,
                  "also FILE_labels.png, FILE_depth.png, FILE_coverage.png, for looking at");
    add_common_options(*app, options->common);
    app->footer("Example: atropos render scenes/auto_scissors.yaml --time 2 -o still.png --layers");
    app->callback([&chosen, options] { chosen = [options] { return render(*options); }; });
}

}  // namespace atropos::experiments
