#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "scenes/tracker_config.hpp"

namespace atropos::scenes {

/// The endoscope's cameras: a preset or a calibration file, and the frame rate.
struct CameraConfig {
    std::string preset = "paper";
    std::string calibration;  ///< file; replaces the preset when not empty
    int width_px = 0;         ///< 0: as calibrated; otherwise the rig is scaled to this width
    int height_px = 0;        ///< 0: follows from the width
    double fps_hz = 30.0;
    double working_distance_m = 0.0;  ///< 0: the preset's
    double k1 = 0.0, k2 = 0.0;        ///< added to the radial distortion of both eyes
    Eigen::Vector3d hand_eye_position_m = Eigen::Vector3d::Zero();    ///< lens in the ECM's tip frame
    Eigen::Vector3d hand_eye_rotation_rad = Eigen::Vector3d::Zero();  ///< rotation vector
};

enum class ThreadModel { kRod, kBulletSoft };
enum class ThreadKnot { kNone, kOverhand };

/// The suture. A material by name, each of its figures replaceable (negative: the material's own).
struct ThreadConfig {
    double length_m = 0.070;
    double diameter_m = 0.00025;
    std::string material = "silk";
    double density_kg_m3 = -1.0;
    double EA_N = -1.0;
    double EI_N_m2 = -1.0;
    double GJ_N_m2 = -1.0;
    double friction = -1.0;
    double natural_curvature_per_m =
        0.0;  ///< of a thread with memory: 1 / the radius it curls to; 0: straight
    ThreadKnot knot = ThreadKnot::kNone;  ///< loose, between the grips, at the start
    ThreadModel model = ThreadModel::kRod;
    int edges = 100;
    std::string colour = "violet";
    bool braided = true;
    double twist_rad = 0.0;
};

enum class ArmAccuracy { kPerfect, kCalibrated, kUncalibrated, kAsRecorded };

/// motion: replay. A recording of an arm's motion, placed into the scene.
struct RecordingConfig {
    std::string file;        ///< kinematics.csv or bare joints (.csv), JIGSAWS' 76 columns (.txt)
    std::string arm;         ///< which of the file's arms; empty: the one of the same name, or the only one
    double rate_hz = 100.0;  ///< of rows without a time
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();    ///< registration, in the recording's frame
    Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();  ///< rotation vector
};

/// motion: waypoints. Of the grip (or blade) frame, against where the arm starts, in the camera's axes.
struct WaypointConfig {
    std::vector<Eigen::Vector3d> offsets_m;
    std::vector<Eigen::Vector3d> turns_rad;  ///< rotation vectors, one an offset; none: no turns
    double blend_m = 0.003;
    double speed_m_s = 0.020;
};

struct ArmConfig {
    std::string tool;
    std::string motion;  ///< hold | manipulate | scissors | waypoints | replay | mid_grasp | pull
    std::string holds;   ///< start | end | nothing
    Eigen::Vector3d base_m = Eigen::Vector3d::Zero();  ///< remote centre in W; zero: the layout's
    std::string meshes{};       ///< folder of a user's meshes of its links; empty: the tool's own
    double mesh_scale_m = 0.0;  ///< metres a unit of theirs
    Eigen::Vector3d park_m =
        Eigen::Vector3d::Zero();  ///< of the third arm's blade point, in W; zero: the layout's
    RecordingConfig recording{};
    WaypointConfig waypoints{};
};

/// motion: mid_grasp. A third arm takes the thread between the grips and lifts it.
struct MidGraspConfig {
    double at_s = 0.5;
    double fraction = 0.5;  ///< of the span between the grips
    double lift_m = 0.010;  ///< back along its jaws
};

/// motion: pull. The holders part, as to tighten a knot, until their thread pulls back.
struct PullConfig {
    double at_s = 0.5;
    double distance_m = 0.012;  ///< of each arm, at most
    double speed_m_s = 0.005;
    double force_N = 1.0;
};

struct ArmsConfig {
    ArmAccuracy accuracy = ArmAccuracy::kCalibrated;
    std::string layout = "default";
    ArmConfig psm1{"large_needle_driver", "manipulate", "start"};
    ArmConfig psm2{"large_needle_driver", "manipulate", "end"};
    ArmConfig psm3{"round_tip_scissors", "scissors", "nothing"};
    double speed_m_s = 0.015;    ///< wanted mean speed of the thread's middle
    double amplitude_m = 0.010;  ///< reach of the random motion
    double tremor_rms_m = 0.0;   ///< of held and manipulating hands per axis, 8 to 12 Hz
    double time_scale = 1.0;     ///< > 1: the arms truly move that much faster
    MidGraspConfig mid_grasp;
    PullConfig pull;
};

struct TissueConfig {
    std::string preset = "organ";  ///< organ | pad | drape | none
    double depth_m = 0.025;        ///< of the surface's mean level below the target
};

enum class RenderPreset { kFast, kQuality };

struct RenderConfig {
    RenderPreset preset = RenderPreset::kFast;
    bool shadows = false;
    std::string back_end = "osmesa";
    double blur_px = 0.55;  ///< Gaussian point spread of the lens on a 640 wide image
};

enum class SensorPreset { kIdeal, kRealistic };

enum class AutoGain { kPreset, kOff, kOn };

/// The camera chips. Negative: the preset's own.
struct SensorConfig {
    SensorPreset preset = SensorPreset::kRealistic;
    double exposure = 1.0;  ///< factor on the light
    AutoGain auto_gain = AutoGain::kPreset;
    double vignetting = -1.0;
    double read_noise = -1.0;
    double shot_noise = -1.0;
    int jpeg_quality = -1;
    double exposure_time_s = 0.0;    ///< motion blur
    double right_eye_delay_s = 0.0;  ///< the right eye is read out later
    double calibration_error = 0.0;  ///< of the rig that is told, in typical errors
};

enum class TipSource { kMeasured, kExact, kNone };

/// The tracker in the loop: what it is, how often it runs, what it is told.
struct TrackingConfig {
    TrackerConfig tracker;
    double rate_hz = 0.0;     ///< frames it takes in a second; 0: every frame
    double latency_s = 0.01;  ///< simulated, capture to estimate
    TipSource tips = TipSource::kMeasured;
};

/// Whose word the scissors take for where the thread is. All but the tracker are null controllers, for
/// comparison.
enum class CutController {
    kTracker,
    kChord,   ///< the straight line between the measured grips, no images
    kFrozen,  ///< the tracker's curve at the moment of the command, ever after
    kTruth,   ///< the simulated thread
};

/// What the scissors are asked to do.
struct CutConfig {
    CutController controller = CutController::kTracker;
    double at_s = 3.0;
    double fraction = 0.5;  ///< of the span between the grips, from the end with the smaller arc length
    double tolerance_m = 0.002;
    int max_attempts = 3;
    double sigmas = 2.0;  ///< of the predicted miss that must be inside the tolerance
};

/// A scene: everything a run depends on besides the program. SI units; the file's keys carry their own.
struct SceneConfig {
    std::string name;
    std::uint64_t seed = 1;
    double duration_s = 10.0;
    CameraConfig camera;
    ThreadConfig thread;
    ArmsConfig arms;
    TissueConfig tissue;
    RenderConfig render;
    SensorConfig sensor;

    TrackingConfig tracking;
    CutConfig cut;
};

}  // namespace atropos::scenes
