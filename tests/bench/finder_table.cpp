// The finder on real, rendered and generated frames: `finder_table [--data FOLDER] [--pictures FOLDER]
// [--frames N]`, as Markdown. FOLDER holds stereo-pairs/ (default: $ATROPOS_DATA).
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "experiments/metrics.hpp"
#include "experiments/overlay.hpp"
#include "experiments/picture_file.hpp"
#include "experiments/sequence.hpp"
#include "experiments/thread_starter.hpp"
#include "scenes/random_stream.hpp"
#include "tests/bench/centre_line.hpp"
#include "tests/support/synthetic_sequence.hpp"
#include "tracker/thread_finder.hpp"

namespace atropos {
namespace {
namespace fs = std::filesystem;
using tracker::FoundThread;
using tracker::ThreadFinder;
using Line = std::vector<Eigen::Vector2d>;

double distance(const Line& line, const Eigen::Vector2d& p) {
    double least = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        const Eigen::Vector2d d = line[i + 1] - line[i];
        const double t = std::clamp((p - line[i]).dot(d) / std::max(d.squaredNorm(), 1e-12), 0.0, 1.0);
        least = std::min(least, (p - line[i] - t * d).norm());
    }
    return least;
}

double mean_distance(const Line& from, const Line& to) {
    double sum = 0.0;
    for (const Eigen::Vector2d& p : from) sum += distance(to, p);
    return from.empty() ? 0.0 : sum / static_cast<double>(from.size());
}

/// The curve as an eye sees it, densely.
Line image_of(const FoundThread& found, int eye) {
    Line line;
    for (const Eigen::Vector3d& p : tracker::sampled(found.curve, 1001).points)
        line.push_back(eye == 0 ? found.rig.project_left(p) : found.rig.project_right(p));
    return line;
}

double cpu_ms() {
    std::timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

/// Best of some runs: what the work costs, not what else the machine does.
template <class Work>
auto timed(int runs, double& ms, Work&& work) {
    auto result = work();
    ms = std::numeric_limits<double>::max();
    for (int i = 0; i < runs; ++i) {
        const double begin = cpu_ms();
        result = work();
        ms = std::min(ms, cpu_ms() - begin);
    }
    return result;
}

void draw(const fs::path& file, const tracker::StereoFrame& frame, const FoundThread& found,
          const Line* reference[2]) {
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
        const auto stroke = [&](const Line& line, const cv::Scalar& colour) {
            for (std::size_t i = 0; i + 1 < line.size(); ++i) {
                if (std::max(line[i].cwiseAbs().maxCoeff(), line[i + 1].cwiseAbs().maxCoeff()) > 1e5)
                    continue;
                cv::line(picture, at(line[i]), at(line[i + 1]), colour, 1, cv::LINE_AA, 4);
            }
        };
        if (reference[eye]) stroke(*reference[eye], {255, 0, 0});
        const Line line = image_of(found, eye);
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

std::vector<fs::path> folders(const fs::path& parent, const std::string& prefix) {
    std::vector<fs::path> list;
    if (fs::exists(parent))
        for (const auto& entry : fs::directory_iterator(parent))
            if (entry.path().filename().string().starts_with(prefix)) list.push_back(entry.path());
    std::sort(list.begin(), list.end());
    return list;
}

struct Options {
    std::string data, pictures;
    int frames = 200;
    int first = 1;
    bool verbose = false;
};

void real_pairs(const Options& options) {
    fmt::print(
        "| real pair | left, px | right, px | within 2 px, left | right | row offset, px | ms "
        "|\n|---|---|---|---|---|---|---|\n");
    for (const fs::path& folder : folders(fs::path(options.data) / "stereo-pairs", "real_")) {
        const experiments::Sequence sequence = experiments::Sequence::open(folder);
        const tracker::StereoFrame frame = sequence.frame(0);
        ThreadFinder finder(sequence.rig());
        double ms = 0.0;
        const auto found = timed(5, ms, [&] { return finder.find(frame); });
        if (!found) {
            fmt::print("| {} | nothing found |\n", folder.filename().string());
            continue;
        }
        double both[2], within[2];
        bench::CentreLine strokes[2] = {bench::stroke_on_white(frame.left),
                                        bench::stroke_on_white(frame.right)};
        bench::leave_needles_out(strokes[0], strokes[1]);
        const Line references[2] = {strokes[0].points, strokes[1].points};
        for (int eye = 0; eye < 2; ++eye) {
            const Line& reference = references[eye];
            Line line = image_of(*found, eye), inside = line;
            const scenes::Camera& camera = sequence.rig().left;
            std::erase_if(inside, [&](const Eigen::Vector2d& p) { return !camera.contains(p); });
            both[eye] = 0.5 * (mean_distance(inside, reference) + mean_distance(reference, line));
            within[eye] =
                100.0 *
                static_cast<double>(std::count_if(reference.begin(), reference.end(),
                                                  [&](const auto& p) { return distance(line, p) <= 2.0; })) /
                static_cast<double>(reference.size());
        }
        fmt::print("| {} | {:.2f} | {:.2f} | {:.1f} % | {:.1f} % | {:.2f} | {:.1f} |\n",
                   folder.filename().string(), both[0], both[1], within[0], within[1], found->row_offset_px,
                   ms);
        if (options.verbose)
            fmt::print("  doubt {} score {:.3f} residual {:.3f} K {} length {:.1f} mm, paths {} {}\n",
                       static_cast<int>(found->doubt), found->score, found->residual_px,
                       found->curve.control_points().size(), 1e3 * found->length_m,
                       found->paths[0].points.size(), found->paths[1].points.size());
        const Line* shown[2] = {&references[0], &references[1]};
        if (!options.pictures.empty())
            draw(fs::path(options.pictures) / (folder.filename().string() + ".png"), frame, *found, shown);
    }
}

double median(std::vector<double> v) {
    std::sort(v.begin(), v.end());
    return v.empty() ? 0.0 : v.size() % 2 ? v[v.size() / 2] : 0.5 * (v[v.size() / 2 - 1] + v[v.size() / 2]);
}

scenes::ThreadEstimate estimate_of(const FoundThread& found) {
    scenes::ThreadEstimate estimate;
    estimate.status = scenes::TrackStatus::kTracking;
    estimate.samples = found.samples;
    return estimate;
}

void sim_pairs(const Options& options) {
    fmt::print(
        "\n| sim pair | 3D, mm | disparity-equivalent, px | 2D, px | length error | row offset, px | ms "
        "|\n|---|---|---|---|---|---|---|\n");
    std::vector<double> errors;
    for (const fs::path& folder : folders(fs::path(options.data) / "stereo-pairs", "sim_")) {
        const experiments::Sequence sequence = experiments::Sequence::open(folder);
        const tracker::StereoFrame frame = sequence.frame(0);
        ThreadFinder finder(sequence.rig());
        double ms = 0.0;
        const auto found = timed(5, ms, [&] { return finder.find(frame); });
        if (!found) {
            fmt::print("| {} | nothing found |\n", folder.filename().string());
            continue;
        }
        const scenes::Polyline truth = experiments::read_truth(folder, 1)[0].span_C;
        const experiments::FrameMetrics m = experiments::compare(estimate_of(*found), truth, sequence.rig());
        const double symmetric = m.symmetric_3d_mm * m.disparity_equivalent_px / m.accuracy_3d_mm;
        errors.push_back(symmetric);
        fmt::print("| {} | {:.3f} | {:.3f} | {:.3f} | {:+.1f} % | {:.2f} | {:.1f} |\n",
                   folder.filename().string(), m.symmetric_3d_mm, symmetric, m.symmetric_2d_px,
                   m.length_error_percent, found->row_offset_px, ms);
        if (options.verbose)
            fmt::print(
                "  doubt {} score {:.3f} residual {:.3f} K {} length {:.1f} mm, true {:.1f} paths {} {}\n",
                static_cast<int>(found->doubt), found->score, found->residual_px,
                found->curve.control_points().size(), 1e3 * found->length_m, 1e3 * truth.length_m(),
                found->paths[0].points.size(), found->paths[1].points.size());
        Line truth_px[2];
        for (const Eigen::Vector3d& p : truth.points) {
            truth_px[0].push_back(sequence.rig().project_left(p));
            truth_px[1].push_back(sequence.rig().project_right(p));
        }
        const Line* shown[2] = {&truth_px[0], &truth_px[1]};
        if (!options.pictures.empty())
            draw(fs::path(options.pictures) / (folder.filename().string() + ".png"), frame, *found, shown);
    }
    fmt::print("| median | | {:.3f} | | | | |\n", median(errors));
}

/// Discrete Frechet distance (Eiter and Mannila 1994) between two lines.
double frechet(const Line& a, const Line& b) {
    std::vector<double> row(b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        double diagonal = 0.0;
        for (std::size_t j = 0; j < b.size(); ++j) {
            const double d = (a[i] - b[j]).norm(), above = row[j];
            const double reach = i == 0 && j == 0 ? 0.0
                                 : i == 0         ? row[j - 1]
                                 : j == 0         ? above
                                                  : std::min({above, diagonal, row[j - 1]});
            row[j] = std::max(d, reach);
            diagonal = above;
        }
    }
    return row.back();
}

/// How often a line crosses itself.
int crossings(const Line& line) {
    const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
        return a.x() * b.y() - a.y() * b.x();
    };
    int count = 0;
    for (std::size_t i = 0; i + 1 < line.size(); ++i)
        for (std::size_t k = i + 2; k + 1 < line.size(); ++k) {
            const Eigen::Vector2d d = line[i + 1] - line[i], e = line[k + 1] - line[k];
            if (cross(d, line[k] - line[i]) * cross(d, line[k + 1] - line[i]) < 0.0 &&
                cross(e, line[i] - line[k]) * cross(e, line[i + 1] - line[k]) < 0.0)
                ++count;
        }
    return count;
}

/// The part of a generated thread that its instruments leave to be seen: their noses are round, of 1.6 mm.
scenes::Polyline visible_part(const scenes::Polyline& truth,
                              const support::SyntheticSequenceOptions& options) {
    const double hidden_m = options.hidden_end_m + 0.0016, L = truth.length_m();
    scenes::Polyline visible;
    for (int i = 0; i <= 200; ++i)
        visible.points.push_back(truth.point_at(hidden_m + (L - 2.0 * hidden_m) * i / 200.0));
    return visible;
}

struct GeneratedCase {
    const char* name;
    bool clutter;
    int crossings;
};

void generated(const Options& options, const GeneratedCase& which) {
    int frames = 0, right = 0, none = 0, sure_right = 0, sure_wrong = 0;
    std::vector<double> errors, lengths, times;
    for (std::uint64_t seed = static_cast<std::uint64_t>(options.first); frames < options.frames; ++seed) {
        support::SyntheticSequenceOptions sequence_options{.seed = seed, .clutter = which.clutter};
        if (which.crossings > 0) {
            scenes::RandomStream random(seed, "finder table");
            sequence_options.turning_rad = random.uniform(4.0, 5.2);
            sequence_options.turning_share = random.uniform(0.35, 0.6);
        }
        const support::SyntheticSequence sequence(sequence_options);
        const scenes::Polyline truth = sequence.truth(0);
        const scenes::Polyline visible = visible_part(truth, sequence_options);
        const scenes::StereoRig& rig = sequence_options.rig;
        Line truth_px[2];
        for (const Eigen::Vector3d& p : visible.points) {
            truth_px[0].push_back(rig.project_left(p));
            truth_px[1].push_back(rig.project_right(p));
        }
        if (crossings(truth_px[0]) != which.crossings || crossings(truth_px[1]) != which.crossings) continue;
        if (!std::all_of(truth_px[0].begin(), truth_px[0].end(),
                         [&](const auto& p) { return rig.left.contains(p); }))
            continue;
        ++frames;
        const support::SyntheticFrame images = sequence.frame(0);
        tracker::StereoFrame frame;
        frame.left = images.left;
        frame.right = images.right;
        frame.instruments = images.instruments_C;
        ThreadFinder finder(rig);
        double ms = 0.0;
        const auto found = timed(1, ms, [&] { return finder.find(frame); });
        times.push_back(ms);
        double off = 1e9;
        if (found) {
            off = 0.0;
            for (int eye = 0; eye < 2; ++eye) {
                Line line = image_of(*found, eye), thin_line;
                for (std::size_t i = 0; i < line.size(); i += 5) thin_line.push_back(line[i]);
                const double one = frechet(thin_line, truth_px[eye]);
                std::reverse(thin_line.begin(), thin_line.end());
                off = std::max(off, std::min(one, frechet(thin_line, truth_px[eye])));
            }
        } else
            ++none;
        const bool good = off <= 8.0;
        if (found && found->doubt == tracker::Doubt::kNone) ++(good ? sure_right : sure_wrong);
        if (good && options.verbose && found->doubt != tracker::Doubt::kNone)
            fmt::print("  seed {}: right, doubt {} score {:.2f}\n", seed, static_cast<int>(found->doubt),
                       found->score);
        if (good) {
            ++right;
            const experiments::FrameMetrics m = experiments::compare(estimate_of(*found), visible, rig);
            errors.push_back(m.disparity_equivalent_px);
            lengths.push_back(std::abs(m.length_error_percent));
        } else if (options.verbose)
            fmt::print(
                "  seed {}: {:.1f} px {}\n", seed, off,
                found ? fmt::format("score {:.3f} doubt {}", found->score, static_cast<int>(found->doubt))
                      : "");
        if (found && !options.pictures.empty() && !good) {
            const Line* shown[2] = {&truth_px[0], &truth_px[1]};
            draw(fs::path(options.pictures) / fmt::format("{}_{}.png", which.crossings, seed), frame, *found,
                 shown);
        }
    }
    fmt::print("| {} | {} | {:.1f} % | {:.1f} % | {:.1f} % | {} | {:.3f} | {:.2f} % | {:.1f} |\n", which.name,
               frames, 100.0 * right / std::max(frames, 1), 100.0 * sure_right / std::max(frames, 1),
               100.0 * sure_wrong / std::max(frames, 1), none, median(errors), median(lengths),
               median(times));
}

/// The refined tracker on generated sequences of which no end is measured, started by the finder.
void tracked(const Options& options) {
    fmt::print(
        "\n| tracked, no end measured | frames | tracking | symmetric mean, mm | 90 % of frames within, mm | "
        "length error "
        "|\n|---|---|---|---|---|---|\n");
    for (std::uint64_t seed = static_cast<std::uint64_t>(options.first);
         seed < static_cast<std::uint64_t>(options.first) + 5; ++seed) {
        const support::SyntheticSequenceOptions sequence_options{.seed = seed};
        const support::SyntheticSequence sequence(sequence_options);
        scenes::TrackerConfig config;
        config.method = scenes::TrackerMethod::kRefined;
        const auto tracker = tracker::make_tracker(config, sequence_options.rig);
        experiments::ThreadStarter starter(config, sequence_options.rig);
        int tracking = 0;
        double symmetric = 0.0, length = 0.0;
        std::vector<double> all;
        for (int i = 0; i < options.frames; ++i) {
            const support::SyntheticFrame images = sequence.frame(i);
            tracker::StereoFrame frame;
            frame.index = i;
            frame.capture_time_s = images.time_s;
            frame.left = images.left;
            frame.right = images.right;
            frame.instruments = images.instruments_C;
            const tracker::TrackResult& result = starter.track(*tracker, frame);
            if (result.estimate.status != scenes::TrackStatus::kTracking) continue;
            ++tracking;
            const experiments::FrameMetrics m = experiments::compare(
                result.estimate, visible_part(images.truth_C, sequence_options), sequence_options.rig);
            symmetric += m.symmetric_3d_mm;
            length += std::abs(m.length_error_percent);
            all.push_back(m.symmetric_3d_mm);
            if (options.verbose && i % 10 == 0)
                fmt::print("  {}: {:.3f} mm length {:+.2f} %\n", i, m.symmetric_3d_mm,
                           m.length_error_percent);
        }
        std::sort(all.begin(), all.end());
        fmt::print("| seed {} | {} | {} | {:.3f} | {:.3f} | {:.2f} % |\n", seed, options.frames, tracking,
                   symmetric / std::max(tracking, 1), all.empty() ? 0.0 : all[all.size() * 9 / 10],
                   length / std::max(tracking, 1));
    }
}

int main_of(int argc, char** argv) {
    CLI::App program;
    Options options;
    if (const char* data = std::getenv("ATROPOS_DATA")) options.data = data;
    std::string only;
    program.add_option("--data", options.data);
    program.add_option("--pictures", options.pictures);
    program.add_option("--frames", options.frames);
    program.add_option("--first-seed", options.first);
    program.add_option("--only", only)
        ->check(CLI::IsMember({"real", "sim", "generated", "crossing", "track"}));
    program.add_flag("--verbose", options.verbose);
    CLI11_PARSE(program, argc, argv);
    if (only.empty() || only == "real") real_pairs(options);
    if (only.empty() || only == "sim") sim_pairs(options);
    const bool plain = only.empty() || only == "generated", crossing = only.empty() || only == "crossing";
    if (plain || crossing)
        fmt::print(
            "\n| generated | frames | right | sure and right | sure and wrong | none found | "
            "disparity-equivalent, px | length error | ms "
            "|\n|---|---|---|---|---|---|---|---|---|\n");
    if (only == "track") tracked(options);
    if (plain) generated(options, {"no crossing, even ground", false, 0});
    if (plain) generated(options, {"no crossing, cluttered", true, 0});
    if (crossing) generated(options, {"one crossing, even ground", false, 1});
    if (crossing) generated(options, {"one crossing, cluttered", true, 1});
    return 0;
}

}  // namespace
}  // namespace atropos

int main(int argc, char** argv) {
    return atropos::main_of(argc, argv);
}
