#pragma once

#include <Eigen/Core>
#include <span>

#include "scenes/capsule.hpp"
#include "scenes/stereo_rig.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::tracker {

struct InstrumentOffsetOptions {
    scenes::ImageChannel channel = scenes::ImageChannel::kGray;
    double prior_sigma_m = 0.0015;  ///< of the measured position, each axis of C
    double shape_sigma_m = 0.0003;  ///< how much its outline may differ from that of its capsules
    double edge_levels = 40.0;      ///< grey levels across an edge that count as a good one
    double least_support = 0.45;    ///< share of the outline that must lie on edges
};

/// How far an instrument is from where it was measured.
struct InstrumentOffset {
    bool found = false;                                    ///< false: keep to the measured pose
    Eigen::Vector3d offset_C = Eigen::Vector3d::Zero();    ///< seen minus measured position (m)
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of it (m^2)
    double wider_m = 0.0;                                  ///< radius seen minus the capsules'
    double support = 0.0;  ///< share of the outline in both eyes that lies on edges
};

/// Shifts the outline of an instrument (capsules in C at the measured pose) until it lies on edges of both
/// images: a search over shifts within three sigma of the prior, then least squares with sub-pixel edges.
/// Only a shift is sought: over a few millimetres a wrong angle is much smaller than a wrong position.
/// `others` (may be empty) hide what lies behind them.
InstrumentOffset find_instrument_offset(const StereoFrame& frame, const scenes::StereoRig& rig,
                                        std::span<const scenes::Capsule> instrument_C,
                                        std::span<const scenes::Capsule> others_C,
                                        const InstrumentOffsetOptions& options = {});

}  // namespace atropos::tracker
