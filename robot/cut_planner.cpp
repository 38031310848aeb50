#include "robot/cut_planner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "robot/arm_clearance.hpp"
#include "robot/blade_pursuit.hpp"

namespace atropos::robot {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kDirections = 24;
constexpr int kWaySteps = 8;
constexpr double kJointRoom_rad = 0.15;
constexpr double kJointRoom_m = 0.01;
constexpr double kThreadRoom_m = 0.004;  // on the way to the stand-off point
constexpr double kViewRoom_m = 0.002;    // between a line of sight and wrist or shaft

// Rounds in which a direction can fail, in order; the farthest one reached is what stands in the way.
enum Obstacle { kReach, kArms, kView, kThread, kNone };
constexpr std::array<const char*, 4> kRefusals = {"the arm cannot reach across the thread there",
                                                  "no way to the thread keeps clear of the other arms",
                                                  "every way to the thread hides it from the endoscope",
                                                  "every way to the stand-off point touches the thread"};

Capsules moved(Capsules capsules, const Isometry3d& X) {
    for (scenes::Capsule& c : capsules) c = {X * c.a, X * c.b, c.radius_m};
    return capsules;
}

double clearance_of(const Capsules& arm, std::span<const scenes::Capsule> others) {
    double least = 1.0;
    for (const scenes::Capsule& a : arm)
        for (const scenes::Capsule& b : others) least = std::min(least, scenes::clearance_m(a, b));
    return least;
}

class Candidate {
  public:
    Candidate(const Psm& psm, const CutScene& scene, const ScissorsOptions& options, const Vector3d& approach,
              double sign)
        : psm_(psm), scene_(scene), options_(options) {
        plan.approach_C = approach;
        plan.tangent_sign = sign;
        R_ = blade_rotation(sign * scene.tangent_C, approach);
        plan.depth_cover = std::abs(R_.col(0).dot(scene.target_C.normalized()));
    }

    CutPlan plan;
    double cost = 0.0;

    Obstacle examine() {
        plan.clearance_m = 1.0;
        Joints q = scene_.q;
        for (int step = 0; step <= kWaySteps; ++step)
            if (const Obstacle o = examine(on_the_way(step / double(kWaySteps)), q, false); o != kNone)
                return o;
        if (const Obstacle o = examine(before_thread(0.5 * options_.standoff_m), q, true); o != kNone)
            return o;
        if (const Obstacle o = examine(before_thread(0.0), q, true); o != kNone) return o;
        cost = 1.0 - plan.depth_cover + 0.15 * (q.tail<2>().norm()) + 0.05 * std::abs(q[3] - scene_.q[3]);
        return kNone;
    }

  private:
    Isometry3d before_thread(double standoff_m) const {
        Isometry3d X = Isometry3d::Identity();
        X.linear() = R_;
        X.translation() = scene_.target_C - standoff_m * R_.col(2);
        return X;
    }

    Isometry3d on_the_way(double share) const {
        const BladeTravel travel(scene_.X_CS, scene_.target_C, options_.standoff_m);
        return travel.at(1.0 - share, scene_.target_C, R_, options_.standoff_m);
    }

    Obstacle examine(const Isometry3d& X_CS, Joints& q, bool at_thread) {
        const auto solution = psm_.inverse(scene_.X_CB.inverse() * X_CS * psm_.tool().X_TS->inverse(), q);
        if (!solution || !has_room(solution.q)) return kReach;
        q = solution.q;
        const Capsules arm = moved(psm_.capsules(q, scene_.open_jaw_rad), scene_.X_CB);
        plan.clearance_m = std::min(plan.clearance_m, clearance_of(arm, scene_.others_C));
        if (plan.clearance_m < options_.clearance_m + options_.clearance_margin_m) return kArms;
        if (hides_target(arm)) return kView;
        if (!at_thread && touches_thread(arm)) return kThread;
        return kNone;
    }

    bool has_room(const Joints& q) const {
        const auto& limits = psm_.limits();
        for (int i = 0; i < 6; ++i) {
            const double room = i == 2 ? kJointRoom_m : kJointRoom_rad;
            if (q[i] < limits.lower[i] + room || q[i] > limits.upper[i] - room) return false;
        }
        return true;
    }

    // Shaft and wrist come first among the capsules.
    bool hides_target(const Capsules& arm) const {
        const size_t bodies = psm_.tool().capsules[kShaft].size() + psm_.tool().capsules[kWrist].size();
        for (const Vector3d& eye : {Vector3d(0.0, 0.0, 0.0), options_.p_CR})
            for (size_t i = 0; i < bodies; ++i)
                if (scenes::clearance_m(arm[i], {eye, scene_.target_C, 0.0}) < kViewRoom_m) return true;
        return false;
    }

    bool touches_thread(const Capsules& arm) const {
        for (size_t i = 0; i + 4 < scene_.thread.size(); i += 4) {
            const scenes::Capsule piece{scene_.thread[i].p_C, scene_.thread[i + 4].p_C, 0.0};
            for (const scenes::Capsule& a : arm)
                if (scenes::clearance_m(a, piece) < kThreadRoom_m) return true;
        }
        return false;
    }

    const Psm& psm_;
    const CutScene& scene_;
    const ScissorsOptions& options_;
    Matrix3d R_;
};

}  // namespace

Matrix3d blade_rotation(const Vector3d& along_thread, const Vector3d& approach) {
    const Vector3d y = along_thread.normalized();
    const Vector3d z = (approach - approach.dot(y) * y).normalized();
    Matrix3d R;
    R << y.cross(z), y, z;
    return R;
}

CutPlan plan_cut(const Psm& psm, const CutScene& scene, const ScissorsOptions& options) {
    const Vector3d along = scene.tangent_C.normalized();
    const Vector3d reach = (scene.target_C - scene.X_CB.translation()).normalized();
    if (std::abs(reach.dot(along)) > 0.95)
        return {.found = false, .refusal = "the thread runs along the instrument, expected it across"};
    const Vector3d straight = (reach - reach.dot(along) * along).normalized();
    CutPlan best;
    double least = 1e9;
    Obstacle farthest = kReach;
    for (int i = 0; i < kDirections; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / kDirections;
        const Vector3d approach = Eigen::AngleAxisd(angle, along) * straight;
        for (const double sign : {1.0, -1.0}) {
            Candidate candidate(psm, scene, options, approach, sign);
            const Obstacle obstacle = candidate.examine();
            farthest = std::max(farthest, obstacle);
            if (obstacle != kNone || candidate.cost >= least) continue;
            least = candidate.cost;
            best = candidate.plan;
            best.found = true;
        }
    }
    if (!best.found) best.refusal = kRefusals[farthest];
    return best;
}

}  // namespace atropos::robot
