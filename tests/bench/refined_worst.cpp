// Pictures of the frames where the refined tracker is worst: numbers do not say why.
#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "tests/bench/refined_run.hpp"
#include "tests/bench/tracker_tables.hpp"
#include "tracker/curve_distance.hpp"

namespace atropos::bench {
namespace {

constexpr int kWorst = 10;

struct Overlay {
    double error_mm;
    std::string name;
    cv::Mat3b picture;
};

void draw_curve(cv::Mat3b& picture, const scenes::Polyline& curve_C, const scenes::StereoRig& rig, int eye,
                double zoom, const cv::Scalar& colour) {
    std::vector<cv::Point> points;
    for (const Eigen::Vector3d& px : tracker::image_of(curve_C, rig, eye).points)
        points.emplace_back(cvRound(16.0 * zoom * (px.x() + 0.5)), cvRound(16.0 * zoom * (px.y() + 0.5)));
    cv::polylines(picture, points, false, colour, 1, cv::LINE_AA, 4);
}

cv::Mat3b overlay_of(const TrackedFrameView& seen) {
    const double zoom = 1280.0 / seen.drawn.left.cols;
    cv::Mat3b eyes[2];
    scenes::Polyline found;
    for (const scenes::ThreadSample& sample : seen.result.estimate.samples)
        found.points.push_back(sample.p_C);
    for (int eye = 0; eye < 2; ++eye) {
        cv::Mat large;
        cv::resize(eye == 0 ? seen.drawn.left : seen.drawn.right, large, {}, zoom, zoom, cv::INTER_CUBIC);
        cv::cvtColor(large, eyes[eye], cv::COLOR_GRAY2BGR);
        draw_curve(eyes[eye], seen.drawn.truth_C, seen.row.options.rig, eye, zoom, {0, 220, 0});
        if (!found.points.empty()) draw_curve(eyes[eye], found, seen.row.options.rig, eye, zoom, {0, 0, 255});
    }
    cv::Mat3b both;
    cv::hconcat(eyes[0], eyes[1], both);
    const std::string words =
        cv::format("%s seed %d frame %d: %.2f mm %.2f px, ", seen.row.name.c_str(),
                   static_cast<int>(seen.row.options.seed), seen.index, seen.error_mm, seen.error_px) +
        scenes::to_string(seen.result.estimate.status);
    cv::putText(both, words, {10, 30}, cv::FONT_HERSHEY_SIMPLEX, 0.8, {0, 255, 255}, 1, cv::LINE_AA);
    return both;
}

}  // namespace

int draw_worst_frames(const std::string& folder, int frames, const SeedRange& seeds,
                      const std::string& wanted) {
    std::filesystem::create_directories(folder);
    for (const RefinedCase& c : refined_cases()) {
        if (c.name.rfind(wanted, 0) != 0) continue;
        std::vector<Overlay> worst;
        const auto keep = [&worst](const TrackedFrameView& seen) {
            if (worst.size() == kWorst && seen.error_mm <= worst.back().error_mm) return;
            if (worst.size() == kWorst) worst.pop_back();
            worst.push_back({seen.error_mm,
                             cv::format("%s_%d_%04d.jpg", seen.row.name.c_str(),
                                        static_cast<int>(seen.row.options.seed), seen.index),
                             overlay_of(seen)});
            std::sort(worst.begin(), worst.end(),
                      [](const Overlay& a, const Overlay& b) { return a.error_mm > b.error_mm; });
        };
        run_row(c, {refined_contender()}, {.frames = frames, .seeds = seeds, .look = keep});
        for (const Overlay& o : worst) cv::imwrite(folder + "/" + o.name, o.picture);
    }
    return 0;
}

}  // namespace atropos::bench
