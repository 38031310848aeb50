#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "scenes/stereo_rig.hpp"
#include "tracker/bordered_band_system.hpp"
#include "tracker/cubic_basis.hpp"
#include "tracker/nuisances.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::tracker {

/// Where the thread was found across the curve, at one sample in one eye: on the line through `point_px`
/// along the tangent, so that `normal` . (pixel - point_px) is the residual.
struct LineMeasurement {
    enum class Kind : unsigned char {
        kMissing,  ///< looked for and not found
        kHidden,   ///< behind an instrument or outside of the image: no data
        kSeen,
    };
    Kind kind = Kind::kMissing;
    Eigen::Vector2d point_px = Eigen::Vector2d::Zero();
    Eigen::Vector2d normal = Eigen::Vector2d::UnitX();
    double sigma_px = 0.05;
    double depth_levels = 0.0;
};

/// What is known of an end of the curve beforehand.
struct EndPrior {
    Eigen::Vector3d p_C = Eigen::Vector3d::Zero();              ///< m
    Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  ///< inverse covariance
    double robust_sigmas = 0.0;                                 ///< Cauchy's scale; 0: none
    bool biased = false;                                        ///< by an arm's error, a nuisance
};

/// An end known equally well in all directions; ends that do not move are known to 0.05 mm.
EndPrior end_prior(const MeasuredTip& tip, double held_sigma_m);

/// Where along the thread it ends, seen in the images.
struct GripPrior {
    Eigen::Vector3d p_C = Eigen::Vector3d::Zero();
    Eigen::Vector3d along = Eigen::Vector3d::UnitX();  ///< unit
    double sigma_m = 0.001;
};

/// What is fitted: a curve and what is unknown beside it.
struct FittedCurve {
    Eigen::Matrix3Xd Q;  ///< 3 x K control points, in C, m
    Nuisances nuisances;
};

/// What the curve of one frame is fitted to.
struct CurveProblem {
    std::array<std::vector<LineMeasurement>, 2> lines;  ///< of each eye, one a sample
    std::array<std::optional<EndPrior>, 2> ends;
    std::array<std::optional<GripPrior>, 2> grips;
    NuisancePrior nuisances;
    double robust_px = 0.5;     ///< Cauchy's scale of the line residuals
    Eigen::Matrix3Xd expected;  ///< control points by motion alone; 3 x K
};

/// Scales of the terms: each residual is divided by its sigma, so that the normal equations are the inverse
/// of a covariance.
struct CurvePriors {
    double stretch_sigma = 0.007;                   ///< |C'(u)| / length - 1 at each sample
    double curvature_sigma_per_m = 30.0;            ///< of C''/length^2 at each of 14 knots
    double curvature_change_sigma_per_m2 = 4000.0;  ///< of C'''/length^3 in each of 13 spans
    double clamp_factor = 3.0;  ///< both sigmas of bending grow by this at the ends: jaws clamp a direction
    double clamp_reach_m = 0.005;   ///< over which that fades (by a factor e)
    double motion_sigma_m = 0.020;  ///< of control points about the motion's prediction
};

/// Continuous refinement of the curve: damped Gauss-Newton on 3K control points and the nuisances. Terms:
/// line residuals of both eyes (Cauchy), length per parameter (eq. 7), bending, ends (II-F), motion, and what
/// is known of the nuisances.
class CurveRefinement {
  public:
    using Covariance = BorderedBandSystem::Covariance;

    CurveRefinement(int control_points, int samples, const CurvePriors& priors, const scenes::StereoRig& rig);

    const CubicBasis& basis() const { return basis_; }
    const std::vector<CubicBasisValues>& samples() const { return samples_; }

    /// Improves `fit` by up to `iterations` steps; returns the cost.
    double refine(const CurveProblem& problem, int iterations, FittedCurve& fit);

    /// Posterior covariance at the solution, of the control points (point by point) and the nuisances, which
    /// are the border. False when something is not determined at all.
    bool covariance(const CurveProblem& problem, const FittedCurve& fit, Covariance& out);

    /// The part of the nuisances' covariance that noise alone makes, which is another one in each frame, with
    /// the other terms taken for true. `covariance` is that of the solution, as above.
    Nuisances::Matrix noise_part(const CurveProblem& problem, const FittedCurve& fit,
                                 const Covariance& covariance) const;

  private:
    using Border = BorderedBandSystem::Border;

    /// A line's residual and its derivatives by the point in C and by the right eye.
    struct LineTerm {
        double r_px;
        Eigen::RowVector3d by_point;
        std::array<double, 2> by_eye;  ///< row and roll
    };
    std::optional<LineTerm> line_term(const LineMeasurement& line, std::size_t eye, std::size_t sample,
                                      const FittedCurve& fit, const scenes::StereoRig& rig) const;
    template <typename Visit>
    int for_each_seen(const CurveProblem& problem, const FittedCurve& fit, Visit&& visit) const;
    double accumulate(const CurveProblem& problem, const FittedCurve& fit, bool normal_equations);
    double add_lines(const CurveProblem& problem, const FittedCurve& fit, bool normal_equations);
    double add_length(const FittedCurve& fit, bool normal_equations);
    double add_nuisances(const CurveProblem& problem, const FittedCurve& fit, bool normal_equations);
    double add_bending(const FittedCurve& fit, double expected_length_m, bool normal_equations);
    double add_points(const CurveProblem& problem, const FittedCurve& fit, bool normal_equations);
    double add_end(std::size_t end, const EndPrior& prior, const FittedCurve& fit, bool normal_equations);
    double add_grip(std::size_t end, const GripPrior& prior, const FittedCurve& fit, bool normal_equations);
    double add_point(int k, const Eigen::Vector3d& error, double weight, bool normal_equations);

    CurvePriors priors_;
    scenes::StereoRig rig_;
    CubicBasis basis_;
    std::vector<CubicBasisValues> samples_;
    std::vector<CubicBasisValues> knots_;
    std::vector<CubicBasisValues> spans_;  ///< third derivatives, in `second_derivative`
    BorderedBandSystem system_;
    Eigen::VectorXd step_;
    Border border_step_, border_J_;
    FittedCurve trial_;
};

}  // namespace atropos::tracker
