// The finder on stereo pairs: real ones, against their thinned strokes, and rendered ones, against the truth.
#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "experiments/metrics.hpp"
#include "experiments/sequence.hpp"
#include "tests/bench/centre_line.hpp"
#include "tests/bench/finder_cases.hpp"

namespace atropos::bench {
namespace fs = std::filesystem;
namespace {

constexpr int kRuns = 5;
constexpr double kNear_px = 2.0;

struct Pair {
    fs::path folder;
    scenes::StereoRig rig;
    tracker::StereoFrame frame;
    tracker::FoundThread found;
    double ms = 0.0;
};

std::vector<fs::path> folders(const fs::path& parent, const std::string& prefix) {
    std::vector<fs::path> list;
    if (fs::exists(parent))
        for (const auto& entry : fs::directory_iterator(parent))
            if (entry.path().filename().string().starts_with(prefix)) list.push_back(entry.path());
    std::sort(list.begin(), list.end());
    return list;
}

/// `print_row` for each pair in which something is found returns the reference, to be drawn.
void for_each_pair(const FinderTableOptions& options, const std::string& prefix,
                   const std::function<std::array<ImageLine, 2>(const Pair&)>& print_row) {
    for (const fs::path& folder : folders(fs::path(options.data) / "stereo-pairs", prefix)) {
        const experiments::Sequence sequence = experiments::Sequence::open(folder);
        const tracker::StereoFrame frame = sequence.frame(0);
        const TimedFind find = timed_find(sequence.rig(), frame, kRuns);
        const std::string name = folder.filename().string();
        if (!find.found) {
            fmt::print("| {} | nothing found |\n", name);
            continue;
        }
        const Pair pair{folder, sequence.rig(), frame, *find.found, find.ms};
        const std::array<ImageLine, 2> reference = print_row(pair);
        if (options.verbose)
            fmt::print("  score {:.3f} residual {:.3f} K {} length {:.1f} mm, paths {} {}\n",
                       pair.found.score, pair.found.residual_px, pair.found.curve.control_points().size(),
                       1e3 * pair.found.length_m, pair.found.paths[0].points.size(),
                       pair.found.paths[1].points.size());
        if (!options.pictures.empty())
            draw(fs::path(options.pictures) / (name + ".png"), frame, pair.found, reference);
    }
}

/// Mean two-sided distance of the curve within the image and the reference, px.
double two_sided_px(const ImageLine& line, const ImageLine& reference, const scenes::Camera& camera) {
    ImageLine inside = line;
    std::erase_if(inside, [&](const Eigen::Vector2d& p) { return !camera.contains(p); });
    return 0.5 * (mean_distance_px(inside, reference) + mean_distance_px(reference, line));
}

/// Of the reference's points that the curve passes near, %.
double near_percent(const ImageLine& line, const ImageLine& reference) {
    const auto near = std::count_if(reference.begin(), reference.end(),
                                    [&](const auto& p) { return distance_px(line, p) <= kNear_px; });
    return 100.0 * static_cast<double>(near) / static_cast<double>(reference.size());
}

}  // namespace

void print_real_pairs(const FinderTableOptions& options) {
    fmt::print(
        "| real pair | left, px | right, px | within 2 px, left | right | row offset, px | doubt | ms |\n"
        "|---|---|---|---|---|---|---|---|\n");
    for_each_pair(options, "real_", [](const Pair& pair) {
        CentreLine left = stroke_on_white(pair.frame.left), right = stroke_on_white(pair.frame.right);
        leave_needles_out(left, right);
        const std::array<ImageLine, 2> reference{left.points, right.points};
        double off_px[2], near[2];
        for (const std::size_t eye : {0, 1}) {
            const ImageLine line = image_of(pair.found, static_cast<int>(eye));
            off_px[eye] = two_sided_px(line, reference[eye], eye == 0 ? pair.rig.left : pair.rig.right);
            near[eye] = near_percent(line, reference[eye]);
        }
        fmt::print("| {} | {:.2f} | {:.2f} | {:.1f} % | {:.1f} % | {:.2f} | {} | {:.0f} |\n",
                   pair.folder.filename().string(), off_px[0], off_px[1], near[0], near[1],
                   pair.found.row_offset_px, name(pair.found.doubt), pair.ms);
        return reference;
    });
}

void print_rendered_pairs(const FinderTableOptions& options) {
    fmt::print(
        "\n| sim pair | 3D, mm | disparity-equivalent, px | 2D, px | length error | row offset, px | doubt | "
        "ms "
        "|\n|---|---|---|---|---|---|---|---|\n");
    std::vector<double> errors_px;
    for_each_pair(options, "sim_", [&](const Pair& pair) {
        const scenes::Polyline truth = experiments::read_truth(pair.folder, 1)[0].span_C;
        const experiments::FrameMetrics m = experiments::compare(estimate_of(pair.found), truth, pair.rig);
        errors_px.push_back(m.symmetric_3d_mm * m.disparity_equivalent_px / m.accuracy_3d_mm);
        fmt::print("| {} | {:.3f} | {:.3f} | {:.3f} | {:+.1f} % | {:.2f} | {} | {:.0f} |\n",
                   pair.folder.filename().string(), m.symmetric_3d_mm, errors_px.back(), m.symmetric_2d_px,
                   m.length_error_percent, pair.found.row_offset_px, name(pair.found.doubt), pair.ms);
        return images_of(truth, pair.rig);
    });
    fmt::print("| median | | {:.3f} | | | | | |\n", median(errors_px));
}

}  // namespace atropos::bench
