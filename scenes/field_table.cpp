#include "scenes/field_table.hpp"

#include <numbers>
#include <utility>

#include "scenes/scene_config.hpp"
#include "scenes/stereo_rig.hpp"

namespace atropos::scenes {

double unit_of_key(std::string_view key) {
    static constexpr std::pair<std::string_view, double> kUnits[] = {
        {"_mm_s", 1e-3}, {"_mm", 1e-3}, {"_ms", 1e-3}, {"_deg", std::numbers::pi / 180.0}, {"_percent", 1e-2},
    };
    for (const auto& [ending, factor] : kUnits)
        if (key.ends_with(ending)) return factor;
    return 1.0;
}

namespace {

Words preset_names() {
    Words names;
    for (const RigPreset& preset : rig_presets()) names.push_back(preset.name);
    return names;
}

void visit_camera(FieldVisitor& v, CameraConfig& c) {
    v.text({"preset", "a rig by name; `atropos info --cameras` lists them with their sources"}, c.preset,
           preset_names());
    v.path({"calibration", "stereo calibration file (OpenCV or ROS YAML, dVRK .ini) in place of the preset"},
           c.calibration);
    v.integer({"width_px", "image width; 0: as calibrated, otherwise the rig is scaled"}, c.width_px, 0,
              8192);
    v.integer({"height_px", "image height; 0: follows from the width"}, c.height_px, 0, 8192);
    v.number({"fps_hz", "frames a second"}, c.fps_hz, {1.0, 1000.0});
    v.number({"working_distance_mm", "lens to target; 0: the preset's"}, c.working_distance_m, {0.0, 500.0});
    v.number({"k1", "added to the radial distortion of both eyes, factor of r^2"}, c.k1, {-0.5, 0.5});
    v.number({"k2", "the same, factor of r^4"}, c.k2, {-0.5, 0.5});
    v.section({"hand_eye", "the left lens in the endoscope arm's tip frame"}, [&] {
        v.vector({"position_mm", "x, y, z"}, c.hand_eye_position_m, {-100.0, 100.0});
        v.vector({"rotation_deg", "rotation vector"}, c.hand_eye_rotation_rad, {-180.0, 180.0});
    });
}

void visit_thread(FieldVisitor& v, ThreadConfig& c) {
    v.number({"length_mm", "length between the two grips"}, c.length_m, {10.0, 500.0});
    v.number({"diameter_mm", "diameter; USP 3-0 is 0.20-0.25"}, c.diameter_m, {0.05, 1.0});
    v.text({"material", "a material by name"}, c.material, {"silk", "polypropylene", "polyglactin", "nylon"});
    v.number({"density_kg_m3", "density; -1: the material's"}, c.density_kg_m3, {-1.0, 10000.0});
    v.number({"EA_N", "axial stiffness; -1: the material's"}, c.EA_N, {-1.0, 1e5});
    v.number({"EI_N_m2", "bending stiffness; -1: the material's"}, c.EI_N_m2, {-1.0, 1e-3});
    v.number({"GJ_N_m2", "twist stiffness; -1: the material's"}, c.GJ_N_m2, {-1.0, 1e-3});
    v.number({"friction", "Coulomb coefficient; -1: the material's"}, c.friction, {-1.0, 2.0});
    v.number({"natural_curvature_per_m",
              "memory: 1 over the radius to which the thread curls when free; 0: straight"},
             c.natural_curvature_per_m, {0.0, 500.0});
    v.choice({"knot", "tied loosely between the grips at the start"}, c.knot, {"none", "overhand"});
    v.choice({"model", "the discrete elastic rod, or Bullet's soft rope for comparison"}, c.model,
             {"rod", "bullet_soft"});
    v.integer({"edges", "edges of the rod; 140 where a knot is tied"}, c.edges, 10, 1000);
    v.text({"colour", "colour of the thread"}, c.colour, {"violet", "black", "blue", "undyed", "red"});
    v.flag({"braided", "braided look (a twist pattern) or a monofilament's sheen"}, c.braided);
    v.number({"twist_deg", "turn of one grip against the other at the start"}, c.twist_rad,
             {-3600.0, 3600.0});
}

void visit_arm(FieldVisitor& v, std::string_view name, ArmConfig& c) {
    v.section({name, "an arm"}, [&] {
        v.text({"tool", "instrument"}, c.tool,
               {"large_needle_driver", "mega_needle_driver", "prograsp", "curved_scissors",
                "round_tip_scissors"});
        v.text({"motion",
                "what moves the arm: PSM1 and PSM2 hold, manipulate, waypoints, replay or pull; PSM3 hold, "
                "scissors, mid_grasp, waypoints or replay"},
               c.motion, {"hold", "manipulate", "scissors", "waypoints", "replay", "mid_grasp", "pull"});
        v.text({"holds",
                "what its jaws hold at the start; PSM1 nothing: the thread is knotted to the tissue there"},
               c.holds, {"start", "end", "nothing"});
        v.vector({"base_mm", "remote centre in W, aimed at the target; [0, 0, 0]: the layout's"}, c.base_m,
                 {-500.0, 500.0});
        v.path({"meshes",
                "folder of your own shaft, wrist, jaw_left, jaw_right (.obj, .stl or .ply) to draw; a link "
                "that isn't there keeps the tool's own"},
               c.meshes);
        v.number({"mesh_scale_m", "metres a unit of these meshes: 0.001 for millimetres; no default"},
                 c.mesh_scale_m, {0.0, 1000.0});
        v.vector({"park_mm", "PSM3: where the blades wait, in W; [0, 0, 0]: the layout's"}, c.park_m,
                 {-500.0, 500.0});
        v.section({"recording", "motion: replay"}, [&] {
            v.path({"file",
                    "a sequence's kinematics.csv, bare joints q1..q6 (.csv), or JIGSAWS' 76 columns (.txt)"},
                   c.recording.file);
            v.text({"arm", "which of the file's arms; empty: the one of the same name, or the only one"},
                   c.recording.arm, {});
            v.number({"rate_hz", "of rows without a time"}, c.recording.rate_hz, {1.0, 10000.0});
            v.section({"registration", "applied to recorded poses, in their own frame"}, [&] {
                v.vector({"position_mm", "x, y, z"}, c.recording.position_m, {-1000.0, 1000.0});
                v.vector({"rotation_deg", "rotation vector"}, c.recording.rotation_rad, {-180.0, 180.0});
            });
        });
        v.section(
            {"waypoints", "from where the arm starts or took the thread (mid_grasp), in the camera's axes"},
            [&] {
                v.vectors({"offsets_mm", "way-points in order"}, c.waypoints.offsets_m, {-100.0, 100.0});
                v.vectors({"turns_deg", "rotation vectors there, one an offset; none: no turns"},
                          c.waypoints.turns_rad, {-170.0, 170.0});
                v.number({"blend_mm", "radius of the rounded corners"}, c.waypoints.blend_m, {0.0, 50.0});
                v.number({"speed_mm_s", "along the way"}, c.waypoints.speed_m_s, {0.1, 500.0});
            });
    });
}

void visit_arms(FieldVisitor& v, ArmsConfig& c) {
    v.choice({"accuracy", "how far measured poses are from true ones"}, c.accuracy,
             {"perfect", "calibrated", "uncalibrated", "as_recorded"});
    v.text({"layout", "where the arms' remote centres are"}, c.layout, {"default", "lab_rig"});
    visit_arm(v, "PSM1", c.psm1);
    visit_arm(v, "PSM2", c.psm2);
    visit_arm(v, "PSM3", c.psm3);
    v.number({"speed_mm_s", "wanted mean speed of the thread's middle under motion: manipulate"}, c.speed_m_s,
             {0.0, 200.0});
    v.number({"amplitude_mm", "reach of motion: manipulate"}, c.amplitude_m, {0.0, 50.0});
    v.number({"tremor_mm", "RMS per axis of the hand's tremor under hold and manipulate, 8 to 12 Hz"},
             c.tremor_rms_m, {0.0, 1.0});
    v.section({"mid_grasp", "motion: mid_grasp, the third arm takes the thread and lifts it"}, [&] {
        v.number({"at_s", "when it sets out"}, c.mid_grasp.at_s, {0.0, 3600.0});
        v.number({"fraction", "where, as a share of the span between the grips"}, c.mid_grasp.fraction,
                 {0.05, 0.95});
        v.number({"lift_mm", "back along its jaws"}, c.mid_grasp.lift_m, {0.0, 50.0});
    });
    v.section({"pull", "motion: pull, the holders part, as to tighten a knot"}, [&] {
        v.number({"at_s", "when they begin"}, c.pull.at_s, {0.0, 3600.0});
        v.number({"distance_mm", "way of each arm, at most"}, c.pull.distance_m, {0.1, 50.0});
        v.number({"speed_mm_s", "of each arm"}, c.pull.speed_m_s, {0.1, 200.0});
        v.number({"force_N", "pull of the thread at which an arm stops"}, c.pull.force_N, {0.001, 100.0});
    });
    v.number({"time_scale", "above 1 the arms truly move that much faster"}, c.time_scale, {0.01, 20.0});
}

void visit_sensor(FieldVisitor& v, SensorConfig& c) {
    v.choice({"preset", "ideal: 8 bits of the light itself; realistic: vignetting, auto-gain, noise, JPEG"},
             c.preset, {"ideal", "realistic"});
    v.number({"exposure", "factor on the light; with auto-gain, less light is more noise"}, c.exposure,
             {0.001, 100.0});
    v.choice({"auto_gain", "brings the mean of both images to a fixed level, by up to 4 times"}, c.auto_gain,
             {"preset", "off", "on"});
    v.number({"vignetting", "0: none, 1: the natural cos^4 law; -1: the preset's"}, c.vignetting,
             {-1.0, 1.0});
    v.number({"read_noise", "standard deviation in the dark, of full scale; -1: the preset's"}, c.read_noise,
             {-1.0, 0.5});
    v.number({"shot_noise",
              "growth of the noise's variance to full scale, in read-noise variances; -1: the preset's"},
             c.shot_noise, {-1.0, 1000.0});
    v.integer({"jpeg_quality", "compression; 0: none, -1: the preset's"}, c.jpeg_quality, -1, 100);
    v.number({"exposure_time_ms", "motion blur over this time before a frame; 0: none"}, c.exposure_time_s,
             {0.0, 100.0});
    v.number({"right_eye_delay_ms", "the left eye is this much older than the right"}, c.right_eye_delay_s,
             {0.0, 100.0});
    v.number({"calibration_error",
              "how far the calibration that is told is from the cameras, in typical errors; 0: exact"},
             c.calibration_error, {0.0, 20.0});
}

void visit_cut(FieldVisitor& v, CutConfig& c) {
    v.choice(
        {"controller", "whose word the scissors take; all but tracker are null controllers, for comparison"},
        c.controller, {"tracker", "chord", "frozen", "truth"});
    v.number({"at_s", "time of the command"}, c.at_s, {0.0, 3600.0});
    v.number({"fraction", "where to cut, as a share of the span between the grips"}, c.fraction,
             {0.05, 0.95});
    v.number({"tolerance_mm", "largest error along the thread that counts as cut"}, c.tolerance_m,
             {0.1, 20.0});
    v.integer({"max_attempts", "approaches before the command aborts"}, c.max_attempts, 1, 20);
    v.number({"sigmas", "how many of its own sigmas a gate leaves room for; 0: none, as the paper cuts"},
             c.sigmas, {0.0, 6.0});
}

void visit_tracker(FieldVisitor& v, TrackingConfig& c) {
    TrackerConfig& t = c.tracker;
    v.choice({"method", "the paper's first or second approximation, or the continuous refinement"}, t.method,
             {"e1", "e2", "refined"});
    v.number({"rate_hz", "frames taken in a second; 0: every frame"}, c.rate_hz, {0.0, 1000.0});
    v.number({"latency_ms", "simulated time from capture to estimate"}, c.latency_s, {0.0, 5000.0});
    v.choice({"tips", "end points it is told: measured by the arms, exact (the paper's Table I), or none"},
             c.tips, {"measured", "exact", "none"});
    v.choice({"optimiser", "exact dynamic programming, or iterated conditional modes"}, t.optimiser,
             {"dp", "icm"});
    v.choice({"parameterisation", "3K unknowns in space, or 4K in the images"}, t.parameterisation,
             {"3d", "2d"});
    v.integer({"K", "control points of e1 and e2"}, t.curve.control_points, 4, 64);
    v.integer({"degree", "of the curve"}, t.curve.degree, 2, 7);
    v.integer({"samples", "points along the curve at which the integrals are summed"}, t.curve.samples, 8,
              1000);
    v.section({"thread", "what the tracker knows of the thread"}, [&] {
        v.number({"length_mm", "span between the ends; 0: unknown"}, t.thread.length_m, {0.0, 500.0});
        v.flag({"length_is_known", "C'_ref of eq. 7 from length_mm instead of the initial curve"},
               t.thread.length_is_known);
        v.number({"width_mm", "diameter; sets the detector's scale"}, t.thread.width_m, {0.02, 5.0});
        v.choice({"polarity", "thread against what lies behind it"}, t.thread.polarity,
                 {"dark", "bright", "either"});
        v.choice({"channel", "of colour images"}, t.thread.channel, {"gray", "red", "green", "blue"});
    });
    v.section({"cost_image", "ridge detector and distance transform (II-E)"}, [&] {
        v.integer({"scales", "standard deviations of the Hessian"}, t.cost_image.scales, 1, 8);
        v.number({"scale_step", "ratio between them"}, t.cost_image.scale_step, {1.05, 4.0});
        v.number({"blobness", "Frangi's beta"}, t.cost_image.blobness, positive(10.0));
        v.number({"contrast_levels", "Frangi's c, grey levels"}, t.cost_image.contrast_levels,
                 positive(255.0));
        v.number({"threshold", "of the measure"}, t.cost_image.threshold, {0.0, 1.0});
        v.number({"truncation_px", "of the distance transform, at 640 wide"}, t.cost_image.truncation_px,
                 {1.0, 100.0});
        v.flag({"region_of_interest", "only around the last curve; the same bytes inside it"},
               t.cost_image.region_of_interest);
    });
    v.section({"labels", "the label set L(r, s) (II-D3)"}, [&] {
        v.integer({"r", "labels on each side of each direction; 14 r + 1 in all"}, t.labels.r, 1, 8);
        v.choice({"preset", "spacing by the paper's reach in the image, or s_mm"}, t.labels.preset,
                 {"custom", "paper-table1", "paper-scissors"});
        v.number({"s_mm", "spacing in the first step"}, t.labels.s_m, {0.001, 50.0});
        v.choice({"shape", "the paper's cube, or along the viewing rays"}, t.labels.shape, {"cube", "rays"});
        v.number({"depth_factor", "rays only: spacing along the ray over spacing across"},
                 t.labels.depth_factor, {0.1, 50.0});
        v.integer({"steps", "optimisation steps a frame, with s, s/2, ..."}, t.labels.steps, 1, 6);
    });
    v.number({"lambda1_e1", "length, eq. 10"}, t.lambda1_e1, {0.0, 1e6});
    v.number({"lambda2_e1_per_m", "label difference, eq. 10"}, t.lambda2_e1_per_m, {0.0, 1e6});
    v.number({"lambda1_e2", "length, eq. 15"}, t.lambda1_e2, {0.0, 1e6});
    v.number({"lambda_stereo", "2D parameterisation: squared epipolar distance"}, t.lambda_stereo,
             {0.0, 1e6});
    v.section({"refined", "the continuous refinement"}, [&] {
        v.integer({"K", "control points; 0: as many as length and bends need"}, t.refined.control_points, 0,
                  64);
        v.integer({"samples", "places along the curve that are measured in each eye"}, t.refined.samples, 8,
                  1000);
        v.number({"search_px", "across the predicted curve, at 640 wide"}, t.refined.search_px, {2.0, 100.0});
        v.number({"contrast_levels", "grey levels a thread is darker than both sides, at least"},
                 t.refined.contrast_levels, {0.1, 255.0});
        v.number({"blur_px", "standard deviation of optics and pixel"}, t.refined.blur_px, {0.1, 10.0});
        v.number({"length_sigma_mm", "of a known length"}, t.refined.length_sigma_m, positive(50.0));
        v.number({"tip_sigma_mm", "of measured ends, what is new in each frame"}, t.refined.tip_sigma_m,
                 positive(50.0));
        v.number({"tip_bias_sigma_mm", "of measured ends, each axis: the arm's constant error"},
                 t.refined.tip_bias_sigma_m, {0.0, 50.0});
        v.number({"instrument_sigma_mm", "of measured instruments"}, t.refined.instrument_sigma_m,
                 {0.0, 50.0});
        v.number(
            {"row_sigma_px",
             "of the right eye's rows against the calibration, at 640 wide; 0: it is exact; 1: a real rig"},
            t.refined.row_sigma_px, {0.0, 50.0});
        v.integer({"coasting_frames", "unseen for longer: lost"}, t.refined.coasting_frames, 0, 100000);
        v.flag({"recovery", "discrete search after a failed loss test"}, t.refined.recovery);
        v.path({"prior_file", "how threads deform, from `atropos learn-prior`"}, t.refined.prior_file);
        v.number({"prior_weight", "of that prior; 0: as without"}, t.refined.prior_weight, {0.0, 100.0});
        v.flag({"rod", "predicts by an inextensible rod that the measured ends carry along"}, t.refined.rod);
        v.vector({"gravity_C", "direction of gravity in the left camera, for the rod; [0, 0, 0]: unknown"},
                 t.refined.gravity_C, {-1000.0, 1000.0});
    });
    v.section({"uncertainty", "one standard deviation of e1 and e2, at 640 wide; 0: the method's own"}, [&] {
        v.number({"lateral_px", "across the viewing ray"}, t.uncertainty.lateral_px, {0.0, 100.0});
        v.number({"disparity_px", "along it"}, t.uncertainty.disparity_px, {0.0, 100.0});
    });
    v.section({"end", "the soft ends of eq. 19"}, [&] {
        v.number({"epsilon_mm", "free distance"}, t.tips.epsilon_m, {0.0, 50.0});
        v.number({"weight_per_m", "px at 640 wide, per m"}, t.tips.weight_per_m, {0.0, 1e7});
    });
}

}  // namespace

void visit_fields(FieldVisitor& v, SceneConfig& c) {
    v.text({"name", "a name for tables and reports"}, c.name, {});
    v.seed({"seed", "every random stream derives from it"}, c.seed);
    v.number({"duration_s", "simulated time"}, c.duration_s, positive(3600.0));
    v.section({"camera", "the stereo endoscope"}, [&] { visit_camera(v, c.camera); });
    v.section({"thread", "the suture"}, [&] { visit_thread(v, c.thread); });
    v.section({"arms", "the three instrument arms"}, [&] { visit_arms(v, c.arms); });
    v.section({"tissue", "what lies below"}, [&] {
        v.text({"preset", "kind of background"}, c.tissue.preset, {"organ", "pad", "drape", "none"});
        v.number({"depth_mm", "mean level below the target"}, c.tissue.depth_m, {0.0, 200.0});
    });
    v.section({"render", "how pictures are drawn"}, [&] {
        v.choice({"preset", "fast: no scene anti-aliasing; quality: 2x2 supersampling"}, c.render.preset,
                 {"fast", "quality"});
        v.flag({"shadows", "cast shadows"}, c.render.shadows);
        v.text({"back_end", "off-screen back end; the bytes are the same"}, c.render.back_end,
               {"osmesa", "egl"});
        v.number({"blur_px", "point spread of the lens, standard deviation on a 640 wide image; 0: none"},
                 c.render.blur_px, {0.0, 5.0});
    });
    v.section({"sensor", "the camera chips"}, [&] { visit_sensor(v, c.sensor); });
    v.section({"tracker", "the thread tracker"}, [&] { visit_tracker(v, c.tracking); });
    v.section({"cut", "what the scissors are asked to do"}, [&] { visit_cut(v, c.cut); });
}

}  // namespace atropos::scenes
