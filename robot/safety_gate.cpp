#include "robot/safety_gate.hpp"

#include <algorithm>
#include <cmath>

namespace atropos::robot {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kBladeReach_m = 0.0102;  // of the blades' straight edges beyond the pin
constexpr double kBladeRoot_m = 0.0030;   // nearer to the pin the hub is in the way
constexpr double kFreeBetween_m = 0.001;
constexpr int kFan = 5;

double sigma_along(const Matrix3d& covariance, const Vector3d& direction) {
    return std::sqrt(std::max(0.0, direction.dot(covariance * direction)));
}

// Room between the thread and the nearest edge of the opening, k sigma taken off; the thread at `miss` from
// the blade point, in S.
double room_m(const Vector3d& miss, double sigma_x, double sigma_z, double blade_z_m, double jaw_rad,
              double k) {
    const double z = blade_z_m + miss.z();
    const double across = z * std::tan(0.5 * jaw_rad) - std::abs(miss.x()) - k * sigma_x;
    const double along = std::min(z - kBladeRoot_m, kBladeReach_m - z) - k * sigma_z;
    return std::min(across, along);
}

}  // namespace

double clearance_between_blades_m(const Eigen::Isometry3d& X_CT, double jaw_rad,
                                  std::span<const scenes::Capsule> others_C) {
    const Matrix3d R = X_CT.linear() * R_TG();
    double least = 1.0;
    for (int i = 0; i < kFan; ++i) {
        const double angle = jaw_rad * (i / double(kFan - 1) - 0.5);
        const Vector3d tip =
            X_CT.translation() + kBladeReach_m * (R * Vector3d(std::sin(angle), 0.0, std::cos(angle)));
        for (const scenes::Capsule& other : others_C)
            least = std::min(least, scenes::clearance_m(other, {X_CT.translation(), tip, 0.0}));
    }
    return least;
}

GateDecision judge(const GateScene& scene, const Tool& tool, const ScissorsOptions& options) {
    GateDecision d;
    const Matrix3d R = scene.X_CS.linear();
    const Vector3d x = R.col(0), y = R.col(1), z = R.col(2);
    d.budget = {sigma_along(scene.thread.tracking, y), sigma_along(scene.registration, y),
                sigma_along(scene.thread.prediction, y), scene.mechanics_m};
    const Matrix3d total = scene.thread.tracking + scene.thread.prediction + scene.registration +
                           scene.mechanics_m * scene.mechanics_m * Matrix3d::Identity();
    const Vector3d miss = R.transpose() * (scene.wanted_C - scene.X_CS.translation());
    d.predicted_miss_m = std::abs(miss.y()) + options.sigmas * d.budget.total_m();
    d.predicted_gap_m = room_m(miss, sigma_along(total, x), sigma_along(total, z),
                               tool.X_TS->translation().z(), scene.jaw_rad, options.sigmas);
    if (!scene.tracking)
        d.reason = "the tracker is not tracking";
    else if (!(scene.estimate_age_s <= options.max_estimate_age_s))
        d.reason = "the last estimate is too old";
    else if (!(scene.clearance_m >= options.clearance_m))
        d.reason = "another arm is too near";
    else if (!(clearance_between_blades_m(scene.X_CS * tool.X_TS->inverse(), scene.jaw_rad, scene.others_C) >=
               kFreeBetween_m))
        d.reason = "not only thread lies between the blades";
    else if (!(d.predicted_miss_m <= options.tolerance_m))
        d.reason = "the predicted miss exceeds the tolerance";
    else if (!(d.predicted_gap_m >= 0.0))
        d.reason = "the thread may lie outside the blades";
    d.open = d.reason.empty();
    return d;
}

}  // namespace atropos::robot
