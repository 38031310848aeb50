#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>

#include "scenes/tracker_config.hpp"

namespace atropos::scenes {

/// The endoscope's cameras: a preset or a calibration file, and the frame rate.
struct CameraConfig {
    std::string preset = "paper";
    std::string calibration;  ///< file; replaces the preset when not empty
    int width_px = 0;         ///< 0: as calibrated; otherwise the rig is scaled to this width
    int height_px = 0;        ///< 0: follows from the width
    double fps_hz = 30.0;
    double working_distance_m = 0.0;                                  ///< 0: the preset's
    Eigen::Vector3d hand_eye_position_m = Eigen::Vector3d::Zero();    ///< lens in the ECM's tip frame
    Eigen::Vector3d hand_eye_rotation_rad = Eigen::Vector3d::Zero();  ///< rotation vector
};

enum class ThreadModel { kRod, kBulletSoft };

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
    ThreadModel model = ThreadModel::kRod;
    int edges = 100;
    std::string colour = "violet";
    bool braided = true;
    double twist_rad = 0.0;
};

enum class ArmAccuracy { kPerfect, kCalibrated, kUncalibrated, kAsRecorded };

struct ArmConfig {
    std::string tool;
    std::string motion;  ///< hold | manipulate | scissors
    std::string holds;   ///< start | end | nothing
};

struct ArmsConfig {
    ArmAccuracy accuracy = ArmAccuracy::kCalibrated;
    std::string layout = "default";
    ArmConfig psm1{"large_needle_driver", "manipulate", "start"};
    ArmConfig psm2{"large_needle_driver", "manipulate", "end"};
    ArmConfig psm3{"round_tip_scissors", "scissors", "nothing"};
    double speed_m_s = 0.015;    ///< wanted mean speed of the thread's middle
    double amplitude_m = 0.010;  ///< reach of the random motion
    double time_scale = 1.0;     ///< > 1: the arms truly move that much faster
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
};

enum class SensorPreset { kIdeal, kRealistic };

struct SensorConfig {
    SensorPreset preset = SensorPreset::kRealistic;
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
