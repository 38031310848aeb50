#pragma once

#include <Eigen/Geometry>
#include <string>

#include "robot/scissors_input.hpp"

namespace atropos::robot {

enum class ScissorsState {
    kPark,      ///< waits for the command, watches the thread
    kApproach,  ///< travels with open blades to the stand-off point before the thread
    kAlign,     ///< turns the blades across the thread, waits until the pursuit has settled
    kFollow,    ///< keeps up with the moving target; advances over the thread when the gate allows
    kClose,     ///< shuts the blades, still following, and holds them shut
    kVerify,    ///< opens, backs off and looks
    kRetract,   ///< travels back to the parking pose
    kAbort,     ///< the same, without a cut that was asked for
    kDone,      ///< parked again, or stopped where it stands
};

/// "park", "approach", ...: the words of loop.csv.
const char* to_string(ScissorsState state);

/// One sigma of each part of the miss along the thread, m.
struct ErrorBudget {
    double tracking_m = 0.0;      ///< the tracker's, at the target
    double registration_m = 0.0;  ///< hand-eye and wrist, after the offsets measured in images
    double prediction_m = 0.0;    ///< growth from the last images to the moment of closing
    double mechanics_m = 0.0;     ///< how far the blades lag behind their set-point

    double total_m() const;
};

struct ScissorsStatus {
    ScissorsState state = ScissorsState::kPark;
    bool finished = false;      ///< nothing more will happen
    bool aborted = false;       ///< from kAbort on
    bool succeeded = false;     ///< finished, and the images show the thread cut
    std::string reason;         ///< why it was aborted, or what remains unknown; one line
    bool target_known = false;  ///< the four poses below mean something
    Eigen::Vector3d target_C = Eigen::Vector3d::Zero();  ///< where the thread is to be cut, predicted to now
    Eigen::Vector3d tangent_C = Eigen::Vector3d::UnitX();    ///< of the thread there, from end 0 to end 1
    Eigen::Vector3d velocity_C = Eigen::Vector3d::Zero();    ///< of the target, m/s
    Eigen::Isometry3d X_CS = Eigen::Isometry3d::Identity();  ///< blade point as believed
    Eigen::Vector3d offset_C_m = Eigen::Vector3d::Zero();    ///< of the blades, as estimated from images
    double advance_m = 0.0;         ///< commanded way still to go to the target along z_S
    double predicted_miss_m = 0.0;  ///< along the thread at the moment of closing: bias + k sigma
    double predicted_gap_m =
        0.0;  ///< room left between thread and the nearer blade, less k sigma; negative: may not fit
    bool gate_open = false;
    std::string_view gate_reason;  ///< why it is closed; empty when open
    int attempts = 0;              ///< advances over the thread so far
    ErrorBudget budget;            ///< now; frozen when the close command is given
    double close_time_s = -1.0;    ///< of the last close command; negative: none yet
    CutEvidence verified = CutEvidence::kUnknown;
    double clearance_m = 0.0;  ///< between the instrument and everything else, as measured
};

}  // namespace atropos::robot
