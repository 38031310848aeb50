#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "scenes/stereo_rig.hpp"
#include "tracker/cubic_basis.hpp"
#include "tracker/curve_refinement.hpp"

namespace atropos::tracker {

/// How well a curve is borne out by what was measured along it. A vessel can hold a whole stretch while the
/// mean support stays high: what counts is the worst stretch, and whether the curve has to stretch for it.
struct FitQuality {
    double support = 0.0;          ///< share of the visible samples of both eyes that lie on a valley
    double worst_window = 0.0;     ///< the same in the worst eighth of the curve; hidden samples count half
    double visible = 0.0;          ///< share of the samples that no instrument hides
    double rms_stretch = 0.0;      ///< of |C'(u)| / length - 1
    double rms_residual_px = 0.0;  ///< of the supported samples
    double end_off_m = 0.0;        ///< of the held end that lies farthest from where it was measured

    /// Larger is better; to choose between two fits of one frame.
    double score() const { return support + worst_window - 4.0 * rms_stretch; }
};

struct LossTestOptions {
    double residual_px = 1.5;    ///< a measurement further off does not support the curve
    double worst_window = 0.35;  ///< least support of an eighth of the curve
    double rms_stretch = 0.05;   ///< largest
    double end_off_m = 0.006;    ///< largest: no arm is that far off
};

FitQuality judge_fit(const std::array<std::vector<LineMeasurement>, 2>& lines,
                     std::span<const CubicBasisValues> samples, const Eigen::Matrix3Xd& Q, double length_m,
                     const scenes::StereoRig& rig, const LossTestOptions& options);

bool is_lost(const FitQuality& quality, const LossTestOptions& options);

}  // namespace atropos::tracker
