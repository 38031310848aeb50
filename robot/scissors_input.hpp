#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "robot/arm_state.hpp"
#include "scenes/capsule.hpp"
#include "scenes/thread_estimate.hpp"

namespace atropos::robot {

/// How far an instrument stands from where its kinematics put it, as measured in images: p_C = (p_C by
/// measured joints and registration) + offset.
struct InstrumentOffset {
    double time_s = 0.0;  ///< capture time of the images
    Eigen::Vector3d offset_C_m = Eigen::Vector3d::Zero();
    double sigma_lateral_m = 0.0;  ///< one sigma across the viewing ray, of one axis
    double sigma_depth_m = 0.0;    ///< one sigma along the viewing ray
};

/// What the images say of the thread at the place of the cut.
enum class CutEvidence { kUnknown, kIntact, kCut };

struct CutCheck {
    double time_s = 0.0;  ///< capture time of the images
    CutEvidence evidence = CutEvidence::kUnknown;
};

/// All the scissors command ever learns, once a millisecond. Null and empty mean: nothing new.
struct ScissorsInput {
    double time_s = 0.0;     ///< now
    bool commanded = false;  ///< the cut has been asked for; may stay set
    const scenes::ThreadEstimate* estimate = nullptr;
    Measured<ArmState> scissors;
    /// Arms that hold end 0 and end 1 of the span; empty where the end is fixed.
    std::array<std::optional<Measured<ArmState>>, 2> holders;
    /// Everything to keep clear of, in C, as measured: holding arms, endoscope.
    std::span<const scenes::Capsule> others_C;
    std::optional<InstrumentOffset> blade_offset;
    std::array<std::optional<InstrumentOffset>, 2> grip_offsets;
    std::optional<CutCheck> cut_check;
};

}  // namespace atropos::robot
