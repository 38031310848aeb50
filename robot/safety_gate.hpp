#pragma once

#include <Eigen/Geometry>
#include <span>
#include <string_view>

#include "robot/psm.hpp"
#include "robot/scissors_options.hpp"
#include "robot/scissors_status.hpp"
#include "robot/thread_predictor.hpp"

namespace atropos::robot {

/// All that the decision to close rests on; poses in C.
struct GateScene {
    bool tracking = false;  ///< the tracker's last word
    double estimate_age_s = 1e9;
    ThreadPrediction thread;  ///< now, with the uncertainty it will have at the moment of closing
    Eigen::Isometry3d X_CS = Eigen::Isometry3d::Identity();  ///< blades as believed now
    Eigen::Vector3d wanted_C = Eigen::Vector3d::Zero();  ///< where on the approach the blade point should be
    Eigen::Matrix3d registration = Eigen::Matrix3d::Zero();  ///< covariance of the blade point, m^2
    double mechanics_m = 0.0;                                ///< sigma of the blades' lag
    double jaw_rad = 0.0;                                    ///< the opening to judge by
    double clearance_m = 0.0;                                ///< instrument to everything else
    std::span<const scenes::Capsule> others_C;
};

struct GateDecision {
    bool open = false;
    std::string_view reason;
    double predicted_miss_m = 0.0;
    double predicted_gap_m = 0.0;
    ErrorBudget budget;
};

/// Closes only when every condition holds: tracked, recent, nothing too near, nothing but thread between the
/// blades, the thread inside their opening, and the miss along it inside the tolerance; the last two with
/// `sigmas` standard deviations to spare.
GateDecision judge(const GateScene& scene, const Tool& tool, const ScissorsOptions& options);

/// Clear distance from anything in `others_C` to the triangle between pin and blade tips.
double clearance_between_blades_m(const Eigen::Isometry3d& X_CT, double jaw_rad,
                                  std::span<const scenes::Capsule> others_C);

}  // namespace atropos::robot
