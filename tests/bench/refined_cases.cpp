#include "tests/bench/refined_cases.hpp"

#include <numbers>

#include "scenes/random_stream.hpp"
#include "tests/support/tracking_trial.hpp"

namespace atropos::bench {
namespace {

scenes::StereoRig full_hd() {
    return scenes::parallel_rig(1920, 1080, 1725.0, 0.005);
}

}  // namespace

std::vector<RefinedCase> refined_cases() {
    std::vector<RefinedCase> all;
    const auto add = [&all](const std::string& name, const std::string& words, const RowBounds& bounds,
                            auto&& change) {
        RefinedCase c;
        c.name = name;
        c.words = words;
        c.bounds = bounds;
        change(c);
        all.push_back(c);
    };
    const RowBounds close{.mean_mm = 0.20, .aim_mm = 0.13, .mean_px = 0.06, .aim_px = 0.03};
    for (int a = 1; a <= 5; ++a)
        add("S" + std::to_string(a), "protocol S, acceleration " + std::to_string(a), close,
            [a](RefinedCase& c) { c.options.acceleration = a; });
    for (int a = 1; a <= 5; ++a)
        add("P" + std::to_string(a), "protocol P, K = 8, acceleration " + std::to_string(a),
            {.mean_mm = 0.20, .mean_px = 0.06}, [a](RefinedCase& c) {
                c.options.acceleration = a;
                c.options.protocol = support::Protocol::kP;
                c.control_points = 8;
            });
    add("fast", "13 times the motion", {.mean_mm = 0.35, .aim_mm = 0.2, .lost_percent = 1.0},
        [](RefinedCase& c) { c.options.motion_scale = 13.0; });
    add("hd", "1920x1080 at 100 mm", {.mean_mm = 0.08}, [](RefinedCase& c) { c.options.rig = full_hd(); });
    add("hd-a", "1920x1080 at 70 mm, reading A", {.mean_mm = 0.05}, [](RefinedCase& c) {
        c.options.rig = full_hd();
        c.options.depth_m = 0.070;
    });
    add("baseline", "parallel to the baseline, sag in depth", {.mean_mm = 0.5}, [](RefinedCase& c) {
        c.options.heading_rad = 0.0;
        c.options.arc_tilt_rad = std::numbers::pi / 2.0;
    });
    add("tips", "ends measured 1-3 mm off", {.mean_mm = 0.4},
        [](RefinedCase& c) { c.options.tip_error_m = 0.003; });
    add("grips", "the same with jaws across the thread and tails, from nothing", {}, [](RefinedCase& c) {
        c.options.jaws = true;
        c.options.tail_m = 0.004;
        c.options.tip_error_m = 0.003;
        c.options.tip_jitter_m = 0.0003;
        c.from_tips = true;
    });
    add("occluded", "30 % hidden in 30 frames, masks 1.5 mm off",
        {.mean_mm = 0.6, .lost_percent = 2.0, .frames_to_return = 5}, [](RefinedCase& c) {
            c.options.occlusion_begin = 40;
            c.mask_error_m = 0.0015;
        });
    add("faint", "14 grey levels of contrast at noise 4", {.mean_mm = 1.0, .lost_percent = 10.0},
        [](RefinedCase& c) { c.options.contrast = 14.0; });
    return all;
}

tracker::StereoFrame measured_frame(const RefinedCase& c, const support::SyntheticFrame& drawn, int index) {
    tracker::StereoFrame frame = support::stereo_frame(drawn, index);
    if (!(c.mask_error_m > 0.0)) return frame;
    scenes::RandomStream random(c.options.seed, "mask error");
    for (scenes::Capsule& capsule : frame.instruments) {
        const Eigen::Vector3d error =
            c.mask_error_m * Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
        capsule.a += error;
        capsule.b += error;
    }
    return frame;
}

}  // namespace atropos::bench
