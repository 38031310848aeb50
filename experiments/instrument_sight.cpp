#include "experiments/instrument_sight.hpp"

#include <algorithm>
#include <cmath>

#include "tracker/instrument_offset.hpp"

namespace atropos::experiments {
namespace {

robot::OffsetFilter::Options filter_options(double prior_sigma_m) {
    robot::OffsetFilter::Options options;
    options.prior_sigma_m = std::max(prior_sigma_m / std::sqrt(3.0), 1e-4);  // of one axis
    return options;
}

}  // namespace

InstrumentSight::InstrumentSight(const scenes::StereoRig& rig, scenes::ImageChannel channel,
                                 double prior_sigma_m)
    : rig_(rig), channel_(channel), prior_sigma_m_(prior_sigma_m), filter_(filter_options(prior_sigma_m)) {}

void InstrumentSight::look(const tracker::StereoFrame& frame, const robot::RobotArm& arm,
                           std::span<const scenes::Capsule> others_C) {
    seen_.reset();
    if (prior_sigma_m_ <= 0.0) return;
    const Eigen::Vector3d p_C = arm.measured().value.X_CT.translation();
    if (last_p_C_) filter_.travel((p_C - *last_p_C_).norm(), frame.capture_time_s - last_time_s_);
    last_p_C_ = p_C;
    last_time_s_ = frame.capture_time_s;

    tracker::InstrumentOffsetOptions options;
    options.channel = channel_;
    options.prior_sigma_m = prior_sigma_m_ / std::sqrt(3.0);
    const auto capsules = arm.measured_capsules_C();
    const tracker::InstrumentOffset found =
        tracker::find_instrument_offset(frame, rig_, capsules.value, others_C, options);
    if (!found.found) return;
    const Eigen::Vector3d ray = p_C.normalized();
    const double depth = ray.dot(found.covariance * ray);
    const double lateral = 0.5 * (found.covariance.trace() - depth);
    const robot::InstrumentOffset offset{frame.capture_time_s, found.offset_C,
                                         std::sqrt(std::max(lateral, 1e-12)),
                                         std::sqrt(std::max(depth, 1e-12))};
    if (filter_.update(offset, p_C)) seen_ = offset;
}

}  // namespace atropos::experiments
