#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "tracker/curve_sampling.hpp"
#include "tracker/eye.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::tracker {

/// Weights of the terms, all data in px of a 640 px wide image.
struct EnergyWeights {
    double px_scale = 1.0;      ///< 640 / image width
    double length = 30.0;       ///< lambda of eq. 4 = lambda_1 of eq. 10 or 15
    double smooth_per_m = 0.0;  ///< lambda_2 of eq. 10
    double tip_epsilon_m = 0.0001;
    double tip_per_m = 20000.0;
};

/// Homogeneous control points of both image curves, in the eyes' coordinates.
using ImageControlPoints = std::array<std::vector<Eigen::Vector3d>, 2>;

/// What the energies are taken on: both eyes, their cost images, the ends, and the speed to be kept.
struct EnergyContext {
    const CurveSampling& sampling;
    const std::array<Eye, 2>& eyes;
    std::array<const CostImage*, 2> costs;
    std::span<const double> reference_speed_m;  ///< |C'_ref(u_j)|, one a sample
    std::array<std::optional<MeasuredTip>, 2> tips;
    EnergyWeights weights;
    const ImageControlPoints* image_points = nullptr;  ///< 2D parameterisation: unknowns of their own

    /// Homogeneous image of C(u_j) (eq. 3): of the curve in space, or from the image's own control points.
    Eigen::Vector3d seen(std::size_t eye, std::span<const Eigen::Vector3d> control_points, int j) const {
        return image_points ? sampling.point((*image_points)[eye], j)
                            : eyes[eye].homogeneous(sampling.point(control_points, j));
    }
};

/// |x|_eps of eq. 19: 0 up to epsilon, the norm beyond.
double tip_distance(const Eigen::Vector3d& x, double epsilon);

/// The energy itself, no approximation: eq. 4-7 and 19 of the curve with these control points.
EnergyTerms energy(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points);

/// Share of the samples of both eyes whose cost is at most `within_px` (at 640).
double support(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
               double within_px);

}  // namespace atropos::tracker
