#include "tracker/mode_search.hpp"

#include <algorithm>
#include <cmath>

#include "tracker/energy.hpp"

namespace atropos::tracker {
namespace {

constexpr int kSamples = 32;
constexpr long kJointModes = 3;
constexpr double kReach_px = 24.0;       ///< of the first mode's outermost label, at 640
constexpr double kTruncation_px = 30.0;  ///< of the distances, at 640
constexpr double kLabels[] = {0.0, 0.125, -0.125, 0.25, -0.25, 0.5, -0.5, 1.0, -1.0};  ///< of the reach

double largest_m(const Eigen::VectorXd& mode) {
    return mode.reshaped(3, mode.size() / 3).colwise().norm().maxCoeff();
}

}  // namespace

ModeSearch::ModeSearch(const scenes::TrackerConfig& config, const scenes::StereoRig& rig, int control_points)
    : config_(config),
      rig_(rig),
      eyes_(make_eyes(rig)),
      sampling_(3, control_points, std::max(kSamples, 2 * control_points)),
      speed_m_(static_cast<std::size_t>(sampling_.samples())),
      points_(static_cast<std::size_t>(control_points)) {}

Eigen::Matrix3Xd ModeSearch::nearest(const StereoFrame& frame, const Eigen::Matrix3Xd& Q, double length_m,
                                     const DeformationModes& modes, scenes::WorkerPool& pool) {
    const double px_scale = 640.0 / rig_.left.width_px;
    const double m_per_px = rig_.m_per_px(Q.row(2).mean());
    const int truncation_px = std::clamp(static_cast<int>(std::lround(kTruncation_px / px_scale)), 1,
                                         DistanceTransform::kMaxTruncation);
    StereoCostImages images(config_, ridge_scales_px(config_, 1.0 / m_per_px), truncation_px);
    images.make(frame, pool);
    std::fill(speed_m_.begin(), speed_m_.end(), length_m);
    const EnergyContext context{sampling_, eyes_, images.costs(),
                                speed_m_,  {},    {.px_scale = px_scale, .length = config_.lambda1_e2}};
    const auto energy_of = [&](const Eigen::Matrix3Xd& curve) {
        for (std::size_t k = 0; k < points_.size(); ++k) points_[k] = curve.col(static_cast<int>(k));
        return energy(context, points_).total;
    };
    const double reach =
        kReach_px / px_scale * m_per_px / std::max(1e-9, modes.sigmas_m[0] * largest_m(modes.V.col(0)));
    const auto moved = [&](const Eigen::Matrix3Xd& from, long mode, double label) {
        const Eigen::VectorXd by = label * reach * modes.sigmas_m[mode] * modes.V.col(mode);
        return (from + by.reshaped(3, Q.cols())).eval();
    };
    Eigen::Matrix3Xd best = Q;
    double least = energy_of(Q);
    const auto try_labels = [&](const Eigen::Matrix3Xd& from, long mode, long last, auto&& self) -> void {
        for (const double label : kLabels) {
            const Eigen::Matrix3Xd curve = moved(from, mode, label);
            if (mode < last) {
                self(curve, mode + 1, last, self);
            } else if (const double e = energy_of(curve); e < least) {
                least = e;
                best = curve;
            }
        }
    };
    const long joint = std::min<long>(kJointModes, modes.sigmas_m.size());
    try_labels(Q, 0, joint - 1, try_labels);
    Eigen::Matrix3Xd from;
    for (long mode = joint; mode < modes.sigmas_m.size(); ++mode) {
        from = best;
        try_labels(from, mode, mode, try_labels);
    }
    return best;
}

}  // namespace atropos::tracker
