#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "scenes/capsule.hpp"

namespace atropos::robot {

/// The moving parts of an instrument that are drawn and collide. Every link frame has z distal and, with the
/// wrist straight, y along the jaws' pin (the wrist-yaw axis) and x along the wrist-pitch axis.
///  shaft       origin on the wrist-pitch axis, turns with roll
///  wrist       origin on the wrist-pitch axis, z towards the wrist-yaw axis
///  jaw_left    origin on the wrist-yaw axis; opens towards +x by half the jaw angle
///  jaw_right   origin on the wrist-yaw axis; opens towards -x by half the jaw angle
enum Link { kShaft, kWrist, kJawLeft, kJawRight, kLinkCount };
constexpr std::array<std::string_view, kLinkCount> kLinkNames = {"shaft", "wrist", "jaw_left", "jaw_right"};

enum class ToolKind { kGrasper, kScissors };

/// An instrument. Part numbers, wrist, jaw range: dVRK's share/tool; outlines: own choice within the 8 mm
/// class, jaws 11 mm beyond the wrist-yaw axis.
struct Tool {
    std::string_view name;  ///< as dVRK spells it
    int part_number = 0;
    ToolKind kind = ToolKind::kGrasper;
    double shaft_m = 0.4162;           ///< DH d4
    double pitch_to_yaw_m = 0.0091;    ///< DH a5
    double wrist_pitch_max_rad = 0.0;  ///< limits are symmetric
    double wrist_yaw_max_rad = 0.0;
    double jaw_min_rad = 0.0;  ///< angle between the jaws; below 0 they squeeze, without moving further
    double jaw_max_rad = 0.0;

    /// Grip point G and blade-meeting point S (scissors, suture-cut) in the tip frame T: z distal, y the jaw
    /// pin (dVRK's z6, the way wrist yaw turns), x = y cross z the opening direction.
    Eigen::Isometry3d X_TG = Eigen::Isometry3d::Identity();
    std::optional<Eigen::Isometry3d> X_TS;

    /// Solid of each link, in its link frame.
    std::array<std::vector<scenes::Capsule>, kLinkCount> capsules;
};

/// Orientation of G, S and (closed) jaws in the tip frame: a quarter turn about z_T.
Eigen::Matrix3d R_TG();

/// All instruments, in the order of their part numbers.
const std::vector<Tool>& tools();

/// By dVRK name in either case, with or without "_FORCEPS", or "NAME:PART". Throws std::invalid_argument that
/// lists the known names.
const Tool& tool(std::string_view name);

}  // namespace atropos::robot
