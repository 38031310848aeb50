// Draws the stereo pair that the outside project tracks, and judges what it found.
//   draw_pair FOLDER          writes left.png and right.png, prints the consumer's other arguments
//   draw_pair FOLDER OUTPUT   exit 0 when the curve that the consumer printed lies on the thread
#include <cstdio>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "tests/support/synthetic_sequence.hpp"
#include "tracker/curve_distance.hpp"

int main(int argc, char** argv) {
    using namespace atropos;
    constexpr double kWithin_px = 1.0;
    if (argc != 2 && argc != 3) return 2;
    const support::SyntheticSequenceOptions options{.seed = 7};
    const support::SyntheticFrame drawn = support::SyntheticSequence(options).frame(0);
    const std::string folder = argv[1];
    if (argc == 2) {
        if (!cv::imwrite(folder + "/left.png", drawn.left) ||
            !cv::imwrite(folder + "/right.png", drawn.right))
            return 1;
        std::printf("%g;%g", options.rig.left.fx_px, 1e3 * options.rig.baseline_m());
        for (const Eigen::Vector3d& tip : drawn.tips_C)
            std::printf(";%.6f;%.6f;%.6f", 1e3 * tip.x(), 1e3 * tip.y(), 1e3 * tip.z());
        std::printf(";%g", 1e3 * options.length_m);
        return 0;
    }
    std::ifstream output(argv[2]);
    std::string status;
    output >> status;
    scenes::Polyline found;
    for (Eigen::Vector3d p; output >> p.x() >> p.y() >> p.z();) found.points.push_back(1e-3 * p);
    if (status != "tracking" || found.points.size() != 101) {
        std::printf("status %s, %zu samples\n", status.c_str(), found.points.size());
        return 1;
    }
    const double error_px = tracker::symmetric_image_distance_px(found, drawn.truth_C, options.rig);
    std::printf("%.2f px from the thread\n", error_px);
    return error_px <= kWithin_px ? 0 : 1;
}
