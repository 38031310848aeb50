#include "robot/blade_belief.hpp"

#include <cmath>

namespace atropos::robot {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kMemory_s = 0.3;  // over which the lag's changes are averaged
// The wrist's play moves the blades by millimetres within a few degrees of the wrist's turning; the way over
// which the offset becomes another one, and the way that a turn of one radian stands for.
constexpr double kForget_m = 0.10, kTurn_m = 0.15;

OffsetFilter::Options filter_options(const ScissorsOptions& options) {
    OffsetFilter::Options filter;
    filter.prior_sigma_m = options.registration_sigma_m / std::sqrt(3.0);
    filter.forget_m = kForget_m;
    return filter;
}

}  // namespace

BladeBelief::BladeBelief(const ScissorsOptions& options, const Tool& tool, const Isometry3d& X_CB)
    : X_TS_(*tool.X_TS), X_CB_(X_CB), offset_(filter_options(options)) {}

Vector3d BladeBelief::setpoint_at(double time_s) const {
    for (size_t age = 0; age < count_; ++age) {
        const Sample& sample = history_[(head_ + kHistory - age) % kHistory];
        if (sample.time_s <= time_s + 1e-9) return sample.p_C;
    }
    return history_[(head_ + kHistory + 1 - count_) % kHistory].p_C;
}

void BladeBelief::observe(double time_s, const Isometry3d& X_BT_setpoint,
                          const Measured<ArmState>& measured) {
    const Isometry3d before = X_CS_;
    X_CS_ = X_CB_ * X_BT_setpoint * X_TS_;
    if (count_ > 0) {
        const double turn_rad = Eigen::AngleAxisd(before.linear().transpose() * X_CS_.linear()).angle();
        offset_.travel((X_CS_.translation() - before.translation()).norm() + kTurn_m * turn_rad,
                       PsmArm::kPeriod_s);
    }
    head_ = (head_ + 1) % kHistory;
    count_ = std::min(count_ + 1, kHistory);
    history_[head_] = {time_s, X_CS_.translation()};

    const ArmState& state = measured.value;
    if (!(state.time_s > measured_time_s_)) return;
    const double share = std::min(1.0, (state.time_s - measured_time_s_) / kMemory_s);
    measured_time_s_ = state.time_s;
    lag_ = (state.X_CT * X_TS_).translation() - setpoint_at(state.time_s);
    mean_lag_ += share * (lag_ - mean_lag_);
    lag_variance_m2_ += share * ((lag_ - mean_lag_).squaredNorm() / 3.0 - lag_variance_m2_);
}

bool BladeBelief::observe(const InstrumentOffset& offset) {
    return offset_.update(offset, X_CS_.translation());
}

Isometry3d BladeBelief::X_CS() const {
    Isometry3d X = X_CS_;
    X.translation() += lag_ + offset_.offset_C_m();
    return X;
}

double BladeBelief::speed_m_s() const {
    constexpr double kSpan_s = 0.01;
    if (count_ == 0) return 0.0;
    const Sample& newest = history_[head_];
    return (newest.p_C - setpoint_at(newest.time_s - kSpan_s)).norm() / kSpan_s;
}

double BladeBelief::mechanics_m() const {
    return std::sqrt(lag_variance_m2_);
}

}  // namespace atropos::robot
