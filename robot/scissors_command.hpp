#pragma once

#include "robot/blade_belief.hpp"
#include "robot/blade_pursuit.hpp"
#include "robot/cut_planner.hpp"
#include "robot/give_way.hpp"
#include "robot/psm_arm.hpp"
#include "robot/safety_gate.hpp"
#include "robot/scissors_input.hpp"
#include "robot/scissors_options.hpp"
#include "robot/scissors_status.hpp"
#include "robot/thread_predictor.hpp"

namespace atropos::robot {

/// Cuts the tracked thread: a state machine that turns estimates and measured poses into commands of one
/// arm. Call step() before the arm's own step(), once every PsmArm::kPeriod_s.
class ScissorsCommand {
  public:
    /// `arm` must outlive the command and takes orders from nobody else; its joints at this moment are the
    /// parking pose. `X_CB`: its base in C as registered. Throws std::invalid_argument when the instrument
    /// has no blades or an option makes no sense.
    ScissorsCommand(const ScissorsOptions& options, PsmArm& arm, const Eigen::Isometry3d& X_CB);

    const ScissorsStatus& step(const ScissorsInput& input);
    const ScissorsStatus& status() const { return status_; }

  private:
    void observe(const ScissorsInput& input);
    void observe_estimate(const scenes::ThreadEstimate& estimate);
    void observe_check(const CutCheck& check);
    void watch_arm();
    void watch_thread();
    void act(const ScissorsInput& input);
    void drive();
    void report();

    void park(const ScissorsInput& input);
    void approach();
    void align();
    void follow();
    void close(const ScissorsInput& input);
    void verify();
    void go_home();

    bool set_out();
    void enter(ScissorsState state);
    void abort(std::string reason);
    void finish();
    void freeze();
    void open_blades();
    void blocked(const char* why);
    Neighbourhood neighbourhood_at(const Joints& q) const;
    bool before_close() const;
    bool gate_open_for(double duration_s) const;
    double in_state_s() const { return now_s_ - entered_s_; }
    BladePursuit::Goal goal() const;
    Eigen::Isometry3d setpoint_X_CS() const;
    Eigen::Isometry3d on_way_X_CS() const;  // had it not given way

    static constexpr double kNever_s = 1e18;

    ScissorsOptions options_;
    PsmArm& arm_;
    Eigen::Isometry3d X_CB_;
    ThreadPredictor thread_;
    BladeBelief blade_;
    BladePursuit pursuit_;
    GiveWay give_way_;
    Neighbourhood neighbourhood_;
    CutPlan plan_;
    ScissorsStatus status_;

    double parked_jaw_rad_;
    Eigen::Isometry3d parked_X_CS_;
    double open_jaw_rad_;
    double closing_s_;  // from open blades to shut ones

    std::span<const scenes::Capsule> others_C_;
    double now_s_ = 0.0, entered_s_ = 0.0, commanded_s_ = -1.0;
    double arrival_s_ = -1e9;  // of the last estimate, used or not
    bool tracking_ = false;
    bool driving_ = false;
    bool frozen_ = false;  // the goal stands where it was
    BladePursuit::Goal frozen_goal_;
    double gate_open_since_s_ = kNever_s, gate_shut_since_s_ = 0.0, settled_since_s_ = kNever_s;
    double stalled_since_s_ = kNever_s, blocked_since_s_ = kNever_s;
    const char* block_ = "";
    double planned_s_ = -1e9;
    CutEvidence evidence_ = CutEvidence::kUnknown;
    int evidence_count_ = 0;
    int closes_ = 0;
    double shut_s_ = -1.0;
    bool homing_ = false;
    bool reached_ = false;  // the blades have been at the thread since they hovered
};

}  // namespace atropos::robot
