// The refined tracker on generated sequences: `refined_tracker_table [--case NAME] [--frames N] [--seeds
// A-B]`.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "scenes/random_stream.hpp"
#include "tests/support/synthetic_sequence.hpp"
#include "tracker/refined_tracker.hpp"

namespace atropos {
namespace {

using scenes::Polyline;
using scenes::TrackStatus;
using support::SyntheticSequence;
using support::SyntheticSequenceOptions;

struct Case {
    std::string name;
    SyntheticSequenceOptions options;
    int control_points = 16;
    double mask_error_m = 0.0;  ///< of the instruments' measured poses
    bool from_tips = false;     ///< begins between the measured ends, as the closed loop does
};

std::vector<Case> cases() {
    std::vector<Case> all;
    const auto add = [&all](const std::string& name, auto&& change) {
        Case c;
        c.name = name;
        change(c);
        all.push_back(c);
    };
    for (int a = 1; a <= 5; ++a) add("S" + std::to_string(a), [a](Case& c) { c.options.acceleration = a; });
    for (int a = 1; a <= 5; ++a)
        add("P" + std::to_string(a), [a](Case& c) {
            c.options.acceleration = a;
            c.options.protocol = support::Protocol::kP;
            c.control_points = 8;
        });
    add("fast", [](Case& c) { c.options.motion_scale = 8.0; });
    add("hd", [](Case& c) { c.options.rig = scenes::parallel_rig(1920, 1080, 1725.0, 0.005); });
    add("hd-a", [](Case& c) {
        c.options.rig = scenes::parallel_rig(1920, 1080, 1725.0, 0.005);
        c.options.depth_m = 0.070;
    });
    add("baseline", [](Case& c) {
        c.options.heading_rad = 0.0;
        c.options.arc_tilt_rad = std::numbers::pi / 2.0;
    });
    add("tips", [](Case& c) { c.options.tip_error_m = 0.003; });
    add("grips", [](Case& c) {
        c.options.jaws = true;
        c.options.tail_m = 0.004;
        c.options.tip_error_m = 0.003;
        c.options.tip_jitter_m = 0.0003;
        c.from_tips = true;
    });
    add("occluded", [](Case& c) {
        c.options.occlusion_begin = 60;
        c.mask_error_m = 0.0015;
    });
    add("faint", [](Case& c) { c.options.contrast = 14.0; });
    return all;
}

struct Tally {
    std::vector<double> values;
    void add(double v) { values.push_back(v); }
    double mean() const {
        double sum = 0.0;
        for (double v : values) sum += v;
        return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
    }
    double quantile(double q) {
        if (values.empty()) return 0.0;
        const std::size_t at = static_cast<std::size_t>(q * static_cast<double>(values.size() - 1));
        std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
        return values[at];
    }
};

double distance_2d(const std::vector<Eigen::Vector2d>& line, const Eigen::Vector2d& p) {
    double best = 1e18;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        const Eigen::Vector2d d = line[i + 1] - line[i];
        const double t = std::clamp((p - line[i]).dot(d) / std::max(d.squaredNorm(), 1e-12), 0.0, 1.0);
        best = std::min(best, (p - line[i] - t * d).squaredNorm());
    }
    return std::sqrt(best);
}

/// One way to build the tracker.
struct Variant {
    std::string name;
    tracker::CurvePriors priors;
    scenes::TrackerConfig::Refined refined;
};

std::vector<Variant> variants(bool all) {
    const scenes::TrackerConfig::Refined refined;
    const tracker::CurvePriors priors;
    std::vector<Variant> list{{"", priors, refined}};
    if (!all) return list;
    const auto add = [&](const std::string& name, auto&& change) {
        list.push_back({name, priors, refined});
        change(list.back());
    };
    add("no length", [](Variant& v) { v.priors.stretch_sigma = 1.0; });
    add("length x0.5", [](Variant& v) { v.priors.stretch_sigma *= 0.5; });
    add("length x2", [](Variant& v) { v.priors.stretch_sigma *= 2.0; });
    add("no bending",
        [](Variant& v) { v.priors.curvature_sigma_per_m = v.priors.curvature_change_sigma_per_m2 = 1e6; });
    add("curvature x0.6", [](Variant& v) { v.priors.curvature_sigma_per_m *= 0.6; });
    add("curvature x2", [](Variant& v) { v.priors.curvature_sigma_per_m *= 2.0; });
    add("change x0.5", [](Variant& v) { v.priors.curvature_change_sigma_per_m2 *= 0.5; });
    add("change x2", [](Variant& v) { v.priors.curvature_change_sigma_per_m2 *= 2.0; });
    add("change x4 cur x.5", [](Variant& v) {
        v.priors.curvature_change_sigma_per_m2 *= 4.0;
        v.priors.curvature_sigma_per_m *= 0.5;
    });
    add("motion 3 mm", [](Variant& v) { v.priors.motion_sigma_m = 0.003; });
    add("tips 0.1 mm", [](Variant& v) { v.refined.tip_sigma_m = 0.0001; });
    add("no tip bias", [](Variant& v) { v.refined.tip_bias_sigma_m = 0.0; });
    add("tips 1 mm", [](Variant& v) { v.refined.tip_sigma_m = 0.001; });
    add("K 12", [](Variant& v) { v.refined.control_points = 12; });
    add("K 20", [](Variant& v) { v.refined.control_points = 20; });
    add("no recovery", [](Variant& v) { v.refined.recovery = false; });
    add("search 20", [](Variant& v) { v.refined.search_px = 20.0; });
    add("contrast 3", [](Variant& v) { v.refined.contrast_levels = 3.0; });
    return list;
}

struct Row {
    Tally error_mm, error_px, middle_mm, frame_ms, sigma_depth_mm, sigma_lateral_mm;
    Tally depth_ratio, lateral_ratio, along_ratio, sigma_along_mm;  ///< offset over its sigma
    Tally bad_confidence, good_confidence;
    int frames = 0, failures = 0, events = 0, silent = 0, lost = 0, coasting = 0;
};

bool verbose = false;

double mask_error_m = 0.0;

double cpu_time_s() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void score(const Case& c, const support::SyntheticFrame& drawn, const tracker::RefinedTracker& tracker,
           const scenes::ThreadEstimate& estimate, bool& failed, Row& row);

void run(const Case& c, std::uint64_t seed, int frames, const std::vector<Variant>& list,
         std::vector<Row>& rows) {
    SyntheticSequenceOptions options = c.options;
    options.seed = seed;
    const SyntheticSequence sequence(options);
    std::vector<std::unique_ptr<tracker::RefinedTracker>> trackers;
    for (const Variant& v : list) {
        scenes::TrackerConfig config;
        config.method = scenes::TrackerMethod::kRefined;
        config.refined = v.refined;
        if (c.control_points != 16) config.refined.control_points = c.control_points;
        config.thread.length_m = options.length_m;
        config.thread.width_m = options.width_m;
        trackers.push_back(std::make_unique<tracker::RefinedTracker>(config, options.rig, v.priors));
    }
    const bool spline = options.protocol == support::Protocol::kP;
    std::vector<char> failed(list.size(), 0);
    for (int i = 0; i < frames; ++i) {
        const support::SyntheticFrame drawn = sequence.frame(i);
        tracker::StereoFrame frame;
        frame.index = i;
        frame.capture_time_s = drawn.time_s;
        frame.left = drawn.left;
        frame.right = drawn.right;
        for (std::size_t end = 0; end < 2; ++end) frame.tips[end] = tracker::MeasuredTip{drawn.tips_C[end]};
        frame.instruments = drawn.instruments_C;
        if (mask_error_m > 0.0) {
            scenes::RandomStream random(seed, "mask error");
            for (scenes::Capsule& capsule : frame.instruments) {
                const Eigen::Vector3d error =
                    mask_error_m *
                    Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
                capsule.a += error;
                capsule.b += error;
            }
        }
        for (std::size_t v = 0; v < list.size(); ++v) {
            tracker::RefinedTracker& tracker = *trackers[v];
            const double began_s = cpu_time_s();
            const tracker::TrackResult& result =
                i == 0 && !c.from_tips
                    ? tracker.start(frame,
                                    tracker::fit_curve(drawn.truth_C, {.control_points = spline ? 8 : 16,
                                                                       .length_weight = spline ? 0.0 : 0.3}))
                    : tracker.track(frame);
            rows[v].frame_ms.add(1e3 * (cpu_time_s() - began_s));
            bool bad = failed[v] != 0;
            score(c, drawn, tracker, result.estimate, bad, rows[v]);
            failed[v] = bad;
            if (verbose)
                std::printf("%4d %.3f mm %.3f px sup %.2f win %.2f str %.4f res %.3f vis %.2f %s\n", i,
                            rows[v].error_mm.values.empty() ? 0.0 : rows[v].error_mm.values.back(),
                            rows[v].error_px.values.empty() ? 0.0 : rows[v].error_px.values.back(),
                            tracker.quality().support, tracker.quality().worst_window,
                            tracker.quality().rms_stretch, tracker.quality().rms_residual_px,
                            tracker.quality().visible, scenes::to_string(result.estimate.status));
        }
    }
}

void score(const Case& c, const support::SyntheticFrame& drawn, const tracker::RefinedTracker& tracker,
           const scenes::ThreadEstimate& estimate, bool& failed, Row& row) {
    const SyntheticSequenceOptions& options = c.options;
    const double scale = options.rig.left.width_px / 640.0;
    (void)tracker;
    {
        ++row.frames;
        if (estimate.status == TrackStatus::kLost) {
            ++row.lost;
            ++row.failures;
            if (!failed) ++row.events;
            failed = true;
            return;
        }
        if (estimate.status == TrackStatus::kCoasting) ++row.coasting;
        std::vector<Eigen::Vector2d> image[2];
        for (const Eigen::Vector3d& p : drawn.truth_C.points) {
            image[0].push_back(options.rig.project_left(p));
            image[1].push_back(options.rig.project_right(p));
        }
        double mm = 0.0, px = 0.0;
        const double n = static_cast<double>(estimate.samples.size());
        const Polyline even = drawn.truth_C.resampled(static_cast<int>(estimate.samples.size()));
        for (std::size_t i = 0; i < estimate.samples.size(); ++i) {
            const scenes::ThreadSample& sample = estimate.samples[i];
            const Eigen::Vector3d tangent = (even.points[std::min(i + 1, even.points.size() - 1)] -
                                             even.points[std::max<std::size_t>(i, 1) - 1])
                                                .normalized();
            row.along_ratio.add(std::abs(tangent.dot(sample.p_C - even.points[i])) / sample.sigma_along_m);
            row.sigma_along_mm.add(1e3 * sample.sigma_along_m);
            const Polyline::Nearest nearest = drawn.truth_C.nearest(sample.p_C);
            mm += 1e3 * nearest.distance_m / n;
            px += 0.5 / n *
                  (distance_2d(image[0], options.rig.project_left(sample.p_C)) +
                   distance_2d(image[1], options.rig.project_right(sample.p_C)));
            const Eigen::Vector3d offset = sample.p_C - nearest.point;
            const Eigen::Vector3d ray = sample.p_C.normalized();
            const double depth = ray.dot(offset);
            row.depth_ratio.add(std::abs(depth) / sample.sigma_depth_m);
            row.lateral_ratio.add((offset - depth * ray).norm() / sample.sigma_lateral_m);
            row.sigma_depth_mm.add(1e3 * sample.sigma_depth_m);
            row.sigma_lateral_mm.add(1e3 * sample.sigma_lateral_m);
        }
        px /= scale;
        row.error_mm.add(mm);
        row.error_px.add(px);
        row.middle_mm.add(1e3 * (estimate.samples[estimate.samples.size() / 2].p_C -
                                 drawn.truth_C.point_at(0.5 * drawn.truth_C.length_m()))
                                    .norm());
        const bool bad = px > 5.0;
        row.failures += bad;
        if (bad && !failed) ++row.events;
        failed = bad;
        const bool wrong = mm > 3.0 || px > 5.0;
        if (wrong && estimate.status == TrackStatus::kTracking) ++row.silent;
        (wrong ? row.bad_confidence : row.good_confidence).add(estimate.confidence);
    }
}

double share_below(Tally& t, double limit) {
    const auto n = std::count_if(t.values.begin(), t.values.end(), [limit](double v) { return v < limit; });
    return t.values.empty() ? 0.0 : 100.0 * static_cast<double>(n) / static_cast<double>(t.values.size());
}

int main_of(int argc, char** argv) {
    std::string wanted;
    bool ablation = false;
    int frames = 200;
    std::uint64_t from = 101, to = 103;
    for (int i = 1; i < argc; ++i) {
        if (!std::strcmp(argv[i], "--verbose")) verbose = true;
        if (!std::strcmp(argv[i], "--ablation")) ablation = true;
        if (i + 1 >= argc) break;
        if (!std::strcmp(argv[i], "--case")) wanted = argv[i + 1];
        if (!std::strcmp(argv[i], "--frames")) frames = std::atoi(argv[i + 1]);
        if (!std::strcmp(argv[i], "--seeds")) {
            const std::string range = argv[i + 1];
            from = std::stoull(range);
            to = std::stoull(range.substr(range.find('-') + 1));
        }
    }
    std::printf(
        "case      frames  3D mm  p95    2D px  mid mm p95    fail%% events lost coast silent "
        "sd mm cov1/2 depth   sl mm  cov1/2 lateral  sa mm cov1/2 along  ms   p99\n");
    for (const Case& c : cases()) {
        if (!wanted.empty() && c.name.rfind(wanted, 0) != 0) continue;
        const std::vector<Variant> list = variants(ablation);
        std::vector<Row> rows(list.size());
        mask_error_m = c.mask_error_m;
        for (std::uint64_t seed = from; seed <= to; ++seed) run(c, seed, frames, list, rows);
        for (std::size_t v = 0; v < list.size(); ++v) {
            Row& row = rows[v];
            std::printf(
                "%-9s %6d %6.3f %6.3f %6.3f %6.3f %6.3f %5.2f %6d %4d %5d %6d %6.3f %4.1f %4.1f  %6.4f %4.1f "
                "%4.1f  %5.3f %4.1f %4.1f  "
                "%5.2f %5.2f %s\n",
                c.name.c_str(), row.frames, row.error_mm.mean(), row.error_mm.quantile(0.95),
                row.error_px.mean(), row.middle_mm.mean(), row.middle_mm.quantile(0.95),
                100.0 * row.failures / row.frames, row.events, row.lost, row.coasting, row.silent,
                row.sigma_depth_mm.mean(), share_below(row.depth_ratio, 1.0),
                share_below(row.depth_ratio, 2.0), row.sigma_lateral_mm.mean(),
                share_below(row.lateral_ratio, 1.0), share_below(row.lateral_ratio, 2.0),
                row.sigma_along_mm.mean(), share_below(row.along_ratio, 1.0),
                share_below(row.along_ratio, 2.0), row.frame_ms.mean(), row.frame_ms.quantile(0.99),
                list[v].name.c_str());
        }
        std::fflush(stdout);
    }
    return 0;
}

}  // namespace

}  // namespace atropos

int main(int argc, char** argv) {
    return atropos::main_of(argc, argv);
}
