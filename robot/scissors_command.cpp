#include "robot/scissors_command.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace atropos::robot {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// Own choices.
// Blades so far behind their set-point, and farther than their speed explains: the arm is stuck.
constexpr double kStall_m = 0.002, kStall_s = 0.10, kUsualLag_s = 0.012;
constexpr double kBlocked_s = 0.30;                        // no way on for so long
constexpr double kSettled_m = 0.001, kSettled_rad = 0.05;  // pursuit has caught up
constexpr double kPlanEvery_s = 0.10, kPlanFor_s = 6.0;
// Stand-off down to which the blades' tips do not reach the thread, and where to decide on going there.
constexpr double kBladesClear_m = 0.005, kDecide_m = 0.007;
constexpr double kWithdrawAfter_s = 0.30;  // gate shut on the way to the thread or beside it
constexpr double kFreeShare = 0.5;  // of the closing, in which the blades are still clear of the thread
constexpr double kShut_rad = 0.03, kShutWithin_s = 1.0;
constexpr double kHomeWithin_s = 15.0;
constexpr int kChecksToBelieve = 3;  // in a row

std::string join(std::string first, std::string_view second) {
    return std::move(first).append(second);
}

std::string text(const char* format, double value) {
    char line[160];
    std::snprintf(line, sizeof line, format, value);
    return line;
}

const Tool& with_blades(const PsmArm& arm) {
    const Tool& tool = arm.psm().tool();
    if (!tool.X_TS)
        throw std::invalid_argument("ScissorsCommand: " + std::string(tool.name) +
                                    " has no blades, expected scissors");
    return tool;
}

BladePursuit::Options pursuit_options(const ScissorsOptions& options) {
    return {options.approach_speed_m_s, options.near_speed_m_s, options.turn_speed_rad_s};
}

}  // namespace

ScissorsCommand::ScissorsCommand(const ScissorsOptions& options, PsmArm& arm, const Isometry3d& X_CB)
    : options_(options),
      arm_(arm),
      X_CB_(X_CB),
      thread_(options),
      blade_(options, with_blades(arm), X_CB),
      pursuit_(pursuit_options(options), setpoint_X_CS()),
      parked_jaw_rad_(arm.jaw_goal_rad()),
      parked_X_CS_(setpoint_X_CS()) {
    options.check();
    const Tool& tool = arm.psm().tool();
    open_jaw_rad_ = std::min(options.open_jaw_rad, tool.jaw_max_rad);
    options_.closed_jaw_rad = std::max(options.closed_jaw_rad, tool.jaw_min_rad);
    const MotionState open{open_jaw_rad_, 0.0, 0.0};
    closing_s_ = MotionProfile::to_rest_at(open, 0.0, arm.limits().jaw).duration_s();
}

Isometry3d ScissorsCommand::setpoint_X_CS() const {
    return X_CB_ * arm_.setpoint_cp() * *arm_.psm().tool().X_TS;
}

Isometry3d ScissorsCommand::on_way_X_CS() const {
    Isometry3d X_CS = setpoint_X_CS();
    X_CS.translation() -= give_way_.offset_m();
    return X_CS;
}

const ScissorsStatus& ScissorsCommand::step(const ScissorsInput& input) {
    now_s_ = input.time_s;
    others_C_ = input.others_C;
    if (status_.finished) return status_;
    observe(input);
    report();
    watch_arm();
    watch_thread();
    act(input);
    if (!status_.finished) drive();
    return status_;
}

// ---- What is known -------------------------------------------------------------------------------------

void ScissorsCommand::observe(const ScissorsInput& input) {
    const bool was_known = thread_.known();
    const BladePursuit::Goal before = was_known ? goal() : BladePursuit::Goal{};
    const Vector3d v_before = was_known ? thread_.at(now_s_).v_C : Vector3d::Zero();
    thread_.observe_grips(input);
    if (input.estimate) observe_estimate(*input.estimate);
    blade_.observe(now_s_, arm_.setpoint_cp(), input.scissors);
    if (input.blade_offset) blade_.observe(*input.blade_offset);
    if (input.cut_check) observe_check(*input.cut_check);
    if (was_known && thread_.known() && !frozen_)
        pursuit_.absorb(before.p_C - goal().p_C, v_before - thread_.at(now_s_).v_C);
}

void ScissorsCommand::observe_estimate(const scenes::ThreadEstimate& estimate) {
    // Once the blades meet the thread, it is no longer what was tracked.
    const double touched_s = status_.close_time_s + kFreeShare * closing_s_;
    if (!before_close() && (status_.close_time_s < 0.0 || estimate.capture_time_s > touched_s)) return;
    arrival_s_ = now_s_;
    const ThreadPredictor::Verdict verdict = thread_.observe(
        estimate, before_close() ? ThreadPredictor::Trust::kUsual : ThreadPredictor::Trust::kWary);
    tracking_ = verdict == ThreadPredictor::Verdict::kUsed;
    if (verdict == ThreadPredictor::Verdict::kJumped && commanded_s_ < 0.0)
        thread_.forget();  // nothing lost yet
}

void ScissorsCommand::observe_check(const CutCheck& check) {
    const bool late_enough =
        before_close() || (status_.state == ScissorsState::kVerify && check.time_s >= entered_s_);
    if (!late_enough || check.evidence == CutEvidence::kUnknown) return;
    evidence_count_ = check.evidence == evidence_ ? evidence_count_ + 1 : 1;
    evidence_ = check.evidence;
}

bool ScissorsCommand::before_close() const {
    return status_.state <= ScissorsState::kFollow;
}

BladePursuit::Goal ScissorsCommand::goal() const {
    if (frozen_) return frozen_goal_;
    const ThreadPrediction thread = thread_.at(now_s_ + options_.arm_lag_s);
    return {thread.p_C - blade_.offset_C_m(),
            blade_rotation(plan_.tangent_sign * thread.tangent_C, plan_.approach_C)};
}

void ScissorsCommand::report() {
    status_.X_CS = blade_.X_CS();
    status_.offset_C_m = blade_.offset_C_m();
    status_.advance_m = pursuit_.standoff_m();
    neighbourhood_ = neighbourhood_at(arm_.setpoint().q);
    status_.clearance_m = neighbourhood_.clearance_m;
    status_.target_known = thread_.known();
    if (!status_.target_known || status_.state > ScissorsState::kClose) return;

    GateScene scene;
    scene.thread = thread_.at(now_s_);
    status_.target_C = scene.thread.p_C;
    status_.tangent_C = scene.thread.tangent_C;
    status_.velocity_C = scene.thread.v_C;
    if (status_.state == ScissorsState::kClose) return;
    // What the images say in the first part of the closing is still followed.
    const double blind_s = (1.0 - kFreeShare) * closing_s_ + pursuit_.delay_s();
    scene.thread.prediction = thread_.growth(now_s_, blind_s);
    scene.tracking = tracking_;
    scene.estimate_age_s = now_s_ - thread_.capture_time_s();
    scene.X_CS = status_.X_CS;
    scene.wanted_C = scene.thread.p_C - pursuit_.standoff_m() * scene.X_CS.linear().col(2);
    scene.registration = blade_.covariance();
    scene.mechanics_m = blade_.mechanics_m();
    scene.jaw_rad = driving_ ? arm_.setpoint().jaw_rad : open_jaw_rad_;
    scene.clearance_m = status_.clearance_m;
    scene.others_C = others_C_;
    const GateDecision decision = judge(scene, arm_.psm().tool(), options_);
    if (decision.open != status_.gate_open)
        (decision.open ? gate_open_since_s_ : gate_shut_since_s_) = now_s_;
    status_.gate_open = decision.open;
    status_.gate_reason = decision.reason;
    status_.predicted_miss_m = decision.predicted_miss_m;
    status_.predicted_gap_m = decision.predicted_gap_m;
    status_.budget = decision.budget;
    const double apart = (scene.wanted_C - scene.X_CS.translation()).norm();
    const double turned =
        Eigen::Quaterniond(scene.X_CS.linear()).angularDistance(Eigen::Quaterniond(goal().R_CS));
    const bool settled = apart < kSettled_m && turned < kSettled_rad;
    settled_since_s_ = settled ? std::min(settled_since_s_, now_s_) : kNever_s;
}

bool ScissorsCommand::gate_open_for(double duration_s) const {
    return status_.gate_open && now_s_ - gate_open_since_s_ >= duration_s;
}

// ---- What must never go on -----------------------------------------------------------------------------

void ScissorsCommand::watch_arm() {
    if (!driving_) return;
    const double behind_m = blade_.lag_C_m().norm();
    stalled_since_s_ = behind_m < kStall_m + kUsualLag_s * blade_.speed_m_s()
                           ? kNever_s
                           : std::min(stalled_since_s_, now_s_);
    if (now_s_ - stalled_since_s_ > kStall_s) {
        abort(text("arm stalled: the blades stand %.1f mm from where they were sent", 1e3 * behind_m));
        arm_.hold();
        finish();
        return;
    }
    if (now_s_ - blocked_since_s_ <= kBlocked_s || !before_close()) return;
    blocked_since_s_ = kNever_s;
    abort(block_);
}

void ScissorsCommand::watch_thread() {
    if (!before_close() || commanded_s_ < 0.0) return;
    if (evidence_ == CutEvidence::kCut && evidence_count_ >= kChecksToBelieve)
        return abort("the images show the thread already cut");
    const double since_s = std::max(commanded_s_, thread_.known() ? thread_.capture_time_s() : -1e9);
    if (now_s_ - since_s > options_.lost_timeout_s) {
        const bool silent = now_s_ - arrival_s_ > 0.5 * options_.lost_timeout_s;
        return abort(silent ? text("tracker lost: no estimate for %.1f s", now_s_ - since_s)
                            : text("tracker lost for %.1f s: ", now_s_ - since_s) + thread_.rejection());
    }
    if (now_s_ - commanded_s_ > options_.timeout_s)
        abort(join(text("time-out after %.0f s: ", options_.timeout_s), status_.gate_reason));
}

// ---- What is done --------------------------------------------------------------------------------------

void ScissorsCommand::act(const ScissorsInput& input) {
    switch (status_.state) {
        case ScissorsState::kPark:
            return park(input);
        case ScissorsState::kApproach:
            return approach();
        case ScissorsState::kAlign:
            return align();
        case ScissorsState::kFollow:
            return follow();
        case ScissorsState::kClose:
            return close(input);
        case ScissorsState::kVerify:
            return verify();
        case ScissorsState::kRetract:
        case ScissorsState::kAbort:
            return go_home();
        case ScissorsState::kDone:
            return;
    }
}

void ScissorsCommand::enter(ScissorsState state) {
    status_.state = state;
    entered_s_ = now_s_;
}

void ScissorsCommand::park(const ScissorsInput& input) {
    if (!input.commanded && commanded_s_ < 0.0) return;
    if (commanded_s_ < 0.0) commanded_s_ = now_s_;
    if (thread_.known() && tracking_) set_out();
}

bool ScissorsCommand::set_out() {
    if (now_s_ - planned_s_ < kPlanEvery_s) return false;
    planned_s_ = now_s_;
    const ThreadPrediction thread = thread_.at(now_s_);
    plan_ = plan_cut(arm_.psm(),
                     {thread.p_C, thread.tangent_C, pursuit_.X_CS(), X_CB_, arm_.goal(), open_jaw_rad_,
                      others_C_, thread_.samples()},
                     options_);
    if (!plan_.found) {
        if (now_s_ - std::max(commanded_s_, entered_s_) > kPlanFor_s) abort(plan_.refusal);
        return false;
    }
    open_blades();
    frozen_ = false;
    driving_ = true;
    pursuit_.travel(goal(), options_.standoff_m);
    enter(ScissorsState::kApproach);
    return true;
}

void ScissorsCommand::open_blades() {
    arm_.jaw_move_jp(open_jaw_rad_);
}

void ScissorsCommand::approach() {
    if (pursuit_.arrived()) enter(ScissorsState::kAlign);
}

void ScissorsCommand::align() {
    if (now_s_ - settled_since_s_ > options_.dwell_s && !arm_.is_jaw_busy()) enter(ScissorsState::kFollow);
}

void ScissorsCommand::follow() {
    const double standoff_m = pursuit_.standoff_m();
    if (pursuit_.at_standoff() && standoff_m > 0.0) {  // hovers
        reached_ = false;
        if (!gate_open_for(options_.dwell_s) || now_s_ - settled_since_s_ < options_.dwell_s) return;
        if (status_.attempts >= options_.max_attempts)
            return abort(text("the gate did not stay open in %.0f attempts", status_.attempts));
        return pursuit_.advance_to(0.0);
    }
    if (!reached_ && standoff_m <= kBladesClear_m) {
        reached_ = true;
        ++status_.attempts;
    }
    const double shut_s = status_.gate_open ? 0.0 : now_s_ - gate_shut_since_s_;
    const bool last_chance = pursuit_.is_advancing() && !reached_ && standoff_m < kDecide_m;
    if (shut_s > (last_chance ? options_.dwell_s : kWithdrawAfter_s))
        return pursuit_.advance_to(options_.standoff_m);
    if (!pursuit_.at_standoff() || !gate_open_for(options_.dwell_s)) return;
    arm_.jaw_move_jp(options_.closed_jaw_rad);
    status_.close_time_s = now_s_;
    shut_s_ = -1.0;
    ++closes_;
    enter(ScissorsState::kClose);
}

void ScissorsCommand::close(const ScissorsInput& input) {
    if (shut_s_ < 0.0 && input.scissors.value.jaw_rad <= std::max(0.0, options_.closed_jaw_rad) + kShut_rad)
        shut_s_ = now_s_;
    const bool held = shut_s_ >= 0.0 && now_s_ - shut_s_ >= options_.hold_s;
    if (!held && in_state_s() < kShutWithin_s) return;
    freeze();
    open_blades();
    if (!held) {
        abort(text("arm stalled: the blades stopped at %.1f degrees",
                   57.29577951308232 * input.scissors.value.jaw_rad));
        return;
    }
    evidence_ = CutEvidence::kUnknown;
    evidence_count_ = 0;
    enter(ScissorsState::kVerify);
}

void ScissorsCommand::verify() {
    if (!arm_.is_jaw_busy() && pursuit_.standoff_m() == 0.0 && pursuit_.at_standoff())
        pursuit_.advance_to(options_.standoff_m);
    if (evidence_count_ >= kChecksToBelieve) {
        status_.verified = evidence_;
        if (evidence_ == CutEvidence::kCut) {
            status_.succeeded = true;
            return enter(ScissorsState::kRetract);
        }
        if (closes_ >= options_.max_attempts || status_.attempts >= options_.max_attempts)
            return abort(
                text("verification disagrees: after %.0f closings the images still show the thread whole",
                     closes_));
        if (!pursuit_.at_standoff() || pursuit_.standoff_m() == 0.0) return;
        thread_.forget();
        tracking_ = false;
        status_.close_time_s = -1.0;
        commanded_s_ = now_s_;
        evidence_count_ = 0;
        return enter(ScissorsState::kPark);
    }
    if (in_state_s() > options_.verify_timeout_s) {
        status_.reason = "the blades closed, the images do not show whether the thread is cut";
        enter(ScissorsState::kRetract);
    }
}

void ScissorsCommand::freeze() {
    if (frozen_) return;
    frozen_goal_ = pursuit_.stand(on_way_X_CS(), thread_.at(now_s_).v_C);
    frozen_ = true;
}

void ScissorsCommand::abort(std::string reason) {
    status_.reason = std::move(reason);
    status_.aborted = true;
    status_.gate_open = false;
    if (!driving_) return finish();
    const bool at_thread = before_close() ? status_.state == ScissorsState::kFollow
                                          : pursuit_.standoff_m() < options_.standoff_m;
    freeze();
    if (at_thread) {
        open_blades();
        pursuit_.advance_to(options_.standoff_m);
    }
    enter(ScissorsState::kAbort);
}

// Straight back from the thread first, then to the parking pose; shut when there.
void ScissorsCommand::go_home() {
    freeze();
    if (!homing_) {
        if (pursuit_.standoff_m() == 0.0 && pursuit_.at_standoff()) pursuit_.advance_to(options_.standoff_m);
        if (!pursuit_.at_standoff()) return;
        homing_ = true;
        frozen_goal_ = {parked_X_CS_.translation(), parked_X_CS_.linear()};
        pursuit_.travel(frozen_goal_, 0.0);
        return;
    }
    if (pursuit_.arrived()) arm_.jaw_move_jp(parked_jaw_rad_);
    if ((pursuit_.arrived() && !arm_.is_jaw_busy()) || in_state_s() > kHomeWithin_s) finish();
}

void ScissorsCommand::finish() {
    status_.finished = true;
    driving_ = false;
    status_.state = ScissorsState::kDone;
}

void ScissorsCommand::drive() {
    if (status_.state != ScissorsState::kClose) give_way_.step(neighbourhood_);
    if (!driving_ && !give_way_.is_aside()) return;
    Isometry3d X_CS = driving_ ? pursuit_.step(goal()) : parked_X_CS_;
    X_CS.translation() += give_way_.offset_m();
    const Psm& psm = arm_.psm();
    const auto solution = psm.inverse(X_CB_.inverse() * X_CS * psm.tool().X_TS->inverse(), arm_.goal());
    if (!solution) return blocked("the target went out of the arm's reach");
    const double clearance = neighbourhood_at(solution.q).clearance_m;
    if (clearance < options_.clearance_m && clearance < status_.clearance_m)
        return blocked("another arm came too near");
    blocked_since_s_ = kNever_s;
    arm_.servo_jp(solution.q);
}

void ScissorsCommand::blocked(const char* why) {
    if (!driving_) return;
    block_ = why;
    blocked_since_s_ = std::min(blocked_since_s_, now_s_);
    pursuit_.yield(on_way_X_CS().translation());
}

/// The instrument at `q`, where the images put it.
Neighbourhood ScissorsCommand::neighbourhood_at(const Joints& q) const {
    const Vector3d offset_C = blade_.offset_C_m();
    std::vector<scenes::Capsule> own_C = arm_.psm().capsules(q, arm_.setpoint().jaw_rad);
    for (scenes::Capsule& c : own_C) c = {X_CB_ * c.a + offset_C, X_CB_ * c.b + offset_C, c.radius_m};
    return neighbourhood(own_C, others_C_, give_way_.wanted_clearance_m());
}

}  // namespace atropos::robot
