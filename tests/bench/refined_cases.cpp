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
    // Worse than what is given rightly by half, at most: 0.09 mm.
    const RowBounds no_worse{.symmetric_mm = 0.135, .length_percent = 2.0};
    add("length-right", "length given", {.length_percent = 2.0}, [](RefinedCase&) {});
    add("length-10", "10 % too long", no_worse, [](RefinedCase& c) { c.told_length = 1.1; });
    add("length-90", "10 % too short", no_worse, [](RefinedCase& c) { c.told_length = 0.9; });
    add("length-none", "not given", no_worse, [](RefinedCase& c) { c.told_length = 0.0; });
    add("length-grows", "given, but 1.5 mm/s are paid out", no_worse,
        [](RefinedCase& c) { c.options.paid_out_m = 0.00005; });
    add("free-right", "end 1 free, length given", no_worse,
        [](RefinedCase& c) { c.options.free_end = true; });
    add("free-10", "end 1 free, 10 % too long", no_worse, [](RefinedCase& c) {
        c.options.free_end = true;
        c.told_length = 1.1;
    });
    add("free-none", "end 1 free, length not given", no_worse, [](RefinedCase& c) {
        c.options.free_end = true;
        c.told_length = 0.0;
    });
    add("length-grows-none", "not given, and 1.5 mm/s are paid out", no_worse, [](RefinedCase& c) {
        c.options.paid_out_m = 0.00005;
        c.told_length = 0.0;
    });
    add("eye-right", "rows right, and doubted", {.mean_mm = 1.3 * 0.09},
        [](RefinedCase& c) { c.row_sigma_px = 1.0; });
    add("eye-1", "rows 1.5 px and 0.2 degrees off", {.mean_mm = 1.3 * 0.09}, [](RefinedCase& c) {
        c.row_offset_px = 1.5;
        c.roll_rad = 0.2 * std::numbers::pi / 180.0;
        c.row_sigma_px = 1.0;
    });
    add("eye-3", "the same, acceleration 3", {.mean_mm = 1.3 * 0.11}, [](RefinedCase& c) {
        c.row_offset_px = 1.5;
        c.roll_rad = 0.2 * std::numbers::pi / 180.0;
        c.row_sigma_px = 1.0;
        c.options.acceleration = 3;
    });
    return all;
}

// The calibration is wrong by it: what the tracker should find.
tracker::EyeCorrection calibration_error(const RefinedCase& c) {
    const double sign = c.options.seed % 2 == 0 ? 1.0 : -1.0, turn = c.options.seed % 4 < 2 ? 1.0 : -1.0;
    return {sign * c.row_offset_px * c.options.rig.left.width_px / 640.0, turn * c.roll_rad};
}

scenes::StereoRig told_rig(const RefinedCase& c) {
    const tracker::EyeCorrection error = calibration_error(c);
    scenes::StereoRig rig = c.options.rig;
    rig.right.cy_px -= error.row_px;
    rig.X_RC = Eigen::AngleAxisd(-error.roll_rad, Eigen::Vector3d::UnitZ()) * rig.X_RC;
    return rig;
}

tracker::StereoFrame measured_frame(const RefinedCase& c, const support::SyntheticFrame& drawn, int index) {
    tracker::StereoFrame frame = support::stereo_frame(drawn, index);
    if (c.options.free_end) frame.tips[1].reset();
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
