// Tracks the thread in one stereo pair with the installed library alone; the pictures come through OpenCV of
// its own. usage: consumer LEFT RIGHT FOCAL_PX BASELINE_MM X0 Y0 Z0 X1 Y1 Z1 LENGTH_MM     (ends in C, mm)
#include <atropos/tracker/stereo_tracker.hpp>
#include <cstdio>
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>

int main(int argc, char** argv) {
    if (argc != 12) {
        std::fprintf(stderr, "usage: consumer LEFT RIGHT FOCAL_PX BASELINE_MM X0 Y0 Z0 X1 Y1 Z1 LENGTH_MM\n");
        return 2;
    }
    using namespace atropos;
    tracker::StereoFrame frame;
    frame.left = cv::imread(argv[1], cv::IMREAD_UNCHANGED);
    frame.right = cv::imread(argv[2], cv::IMREAD_UNCHANGED);
    const auto number = [&](int i) { return std::atof(argv[i]); };
    const scenes::StereoRig rig =
        scenes::parallel_rig(frame.left.cols, frame.left.rows, number(3), 1e-3 * number(4));
    for (int end : {0, 1})
        frame.tips[static_cast<std::size_t>(end)] = tracker::MeasuredTip{
            1e-3 * Eigen::Vector3d(number(5 + 3 * end), number(6 + 3 * end), number(7 + 3 * end))};
    scenes::TrackerConfig config;
    config.thread.length_m = 1e-3 * number(11);
    const auto tracker = tracker::make_tracker(config, rig);
    const tracker::TrackResult& result = tracker->track(frame);
    std::printf("%s\n", scenes::to_string(result.estimate.status));
    for (const auto& sample : result.estimate.samples)
        std::printf("%.3f %.3f %.3f\n", 1e3 * sample.p_C.x(), 1e3 * sample.p_C.y(), 1e3 * sample.p_C.z());
    return 0;
}
