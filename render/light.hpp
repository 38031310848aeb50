#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace atropos::render {

/// The lamp at the endoscope's tip, beside the lenses: one spot with inverse-square fall-off. A white matt
/// surface that faces the lamp at `reference_m` has linear radiance `intensity`. Shape: own choice after
/// rendering.md section 8; the fibre ring of a real endoscope is wider.
struct Light {
    Eigen::Vector3d offset_m{0.0, -0.004, 0.0};  ///< from the middle of the baseline, in C's axes
    double intensity = 1.0;
    double reference_m = 0.1;
    double cos_inner = 0.97;  ///< full light inside this cone about C's z axis
    double cos_outer = 0.62;  ///< none outside this one
    double ambient = 0.10;    ///< share of the lamp's light that comes back from the whole cavity

    /// Radiance of a white matt surface at distance vector `p_LP` from the lamp, facing it.
    double irradiance(const Eigen::Vector3d& p_LP, const Eigen::Vector3d& axis) const {
        const double d2 = p_LP.squaredNorm();
        const double t =
            std::clamp((p_LP.dot(axis) / std::sqrt(d2) - cos_outer) / (cos_inner - cos_outer), 0.0, 1.0);
        return intensity * reference_m * reference_m / d2 * t * t * (3.0 - 2.0 * t);
    }
};

}  // namespace atropos::render
