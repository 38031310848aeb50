#include "tests/bench/finder_cases.hpp"

#include <algorithm>
#include <ctime>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "experiments/picture_file.hpp"

namespace atropos::bench {
namespace fs = std::filesystem;
namespace {

double cpu_ms() {
    std::timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

}  // namespace

TimedFind timed_find(const scenes::StereoRig& rig, const tracker::StereoFrame& frame, int runs,
                     const scenes::TrackerConfig& config) {
    tracker::ThreadFinder finder(rig, tracker::finder_options(config));
    TimedFind result{finder.find(frame), std::numeric_limits<double>::max()};
    for (int i = 0; i < runs; ++i) {
        const double begin = cpu_ms();
        result.found = finder.find(frame);
        result.ms = std::min(result.ms, cpu_ms() - begin);
    }
    return result;
}

const char* name(tracker::Doubt doubt) {
    constexpr const char* kNames[] = {"none", "leap", "rival", "end", "depth", "fit"};
    return kNames[static_cast<std::size_t>(doubt)];
}

scenes::ThreadEstimate estimate_of(const tracker::FoundThread& found) {
    scenes::ThreadEstimate estimate;
    estimate.status = scenes::TrackStatus::kTracking;
    estimate.samples = found.samples;
    return estimate;
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t half = values.size() / 2;
    if (values.empty()) return 0.0;
    return values.size() % 2 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

std::array<ImageLine, 2> images_of(const scenes::Polyline& line_C, const scenes::StereoRig& rig) {
    std::array<ImageLine, 2> lines;
    for (const Eigen::Vector3d& p : line_C.points) {
        lines[0].push_back(rig.project_left(p));
        lines[1].push_back(rig.project_right(p));
    }
    return lines;
}

ImageLine image_of(const tracker::FoundThread& found, int eye) {
    ImageLine line;
    for (const Eigen::Vector3d& p : tracker::sampled(found.curve, 1001).points)
        line.push_back(eye == 0 ? found.rig.project_left(p) : found.rig.project_right(p));
    return line;
}

void draw(const fs::path& file, const tracker::StereoFrame& frame, const tracker::FoundThread& found,
          const std::array<ImageLine, 2>& reference) {
    constexpr int kZoom = 2;
    cv::Mat both;
    for (int eye = 0; eye < 2; ++eye) {
        cv::Mat picture = (eye == 0 ? frame.left : frame.right).clone();
        if (picture.channels() == 1) cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
        cv::resize(picture, picture, {}, kZoom, kZoom, cv::INTER_NEAREST);
        const auto at = [](const Eigen::Vector2d& p) {
            return cv::Point(static_cast<int>(std::lround(16 * (kZoom * p.x() + 0.5 * (kZoom - 1)))),
                             static_cast<int>(std::lround(16 * (kZoom * p.y() + 0.5 * (kZoom - 1)))));
        };
        const auto stroke = [&](const ImageLine& line, const cv::Scalar& colour) {
            for (std::size_t i = 0; i + 1 < line.size(); ++i) {
                if (std::max(line[i].cwiseAbs().maxCoeff(), line[i + 1].cwiseAbs().maxCoeff()) > 1e5)
                    continue;
                cv::line(picture, at(line[i]), at(line[i + 1]), colour, 1, cv::LINE_AA, 4);
            }
        };
        stroke(reference[static_cast<std::size_t>(eye)], {255, 0, 0});
        const ImageLine line = image_of(found, eye);
        stroke(line, {0, 160, 0});
        cv::circle(picture, at(line.front()), 16 * 5, {0, 160, 0}, 1, cv::LINE_AA, 4);
        if (both.empty())
            both = picture;
        else
            cv::hconcat(both, picture, both);
    }
    fs::create_directories(file.parent_path());
    experiments::write_png(file, both);
}

scenes::Polyline visible_part(const scenes::Polyline& truth,
                              const support::SyntheticSequenceOptions& options) {
    const double hidden_m = options.hidden_end_m + 0.0016, L = truth.length_m();
    scenes::Polyline visible;
    for (int i = 0; i <= 200; ++i)
        visible.points.push_back(truth.point_at(hidden_m + (L - 2.0 * hidden_m) * i / 200.0));
    return visible;
}

}  // namespace atropos::bench
