#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "scenes/stereo_rig.hpp"
#include "tracker/bordered_band_system.hpp"
#include "tracker/cubic_basis.hpp"
#include "tracker/deformation_prior.hpp"
#include "tracker/end_belief.hpp"
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

    double squared_error(const Eigen::Vector3d& p) const { return (p - p_C).dot(information * (p - p_C)); }

    /// Of the information, for an end at `p` (IRLS).
    double weight(const Eigen::Vector3d& p) const {
        return robust_sigmas > 0.0 ? 1.0 / (1.0 + squared_error(p) / (robust_sigmas * robust_sigmas)) : 1.0;
    }
};

/// An end known equally well in all directions; ends that do not move are known to 0.05 mm.
EndPrior end_prior(const MeasuredTip& tip, double held_sigma_m);

/// What the curve of one frame is fitted to.
struct CurveProblem {
    std::array<std::vector<LineMeasurement>, 2> lines;  ///< of each eye, one a sample
    std::array<std::optional<EndPrior>, 2> ends;
    double length_m = 0.0;  ///< expected, with its sigma
    double length_sigma_m = 0.0;
    double robust_px = 0.5;        ///< Cauchy's scale of the line residuals
    Eigen::Matrix3Xd expected;     ///< control points by motion alone; 3 x K
    Eigen::Matrix3Xd bent_as;      ///< control points of a curve that bent about as much; empty: straight
    DeformationModes deformation;  ///< about `expected`; empty: nothing was learned
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

/// Continuous refinement of the curve: damped Gauss-Newton on 3K control points and the curve's length.
/// Terms: line residuals of both eyes (Cauchy), length per parameter (eq. 7), bending, ends (II-F), motion,
/// and what was learned of deformation, which the covariance leaves out: a prediction is no second look.
class CurveRefinement {
  public:
    CurveRefinement(int control_points, int samples, const CurvePriors& priors, const scenes::StereoRig& rig);

    /// Other cameras from now on.
    void set_rig(const scenes::StereoRig& rig) { rig_ = rig; }

    const CubicBasis& basis() const { return basis_; }
    const std::vector<CubicBasisValues>& samples() const { return samples_; }

    /// Improves `Q` (3 x K, in C, m) and `length_m` by up to `iterations` steps; returns the cost.
    double refine(const CurveProblem& problem, int iterations, Eigen::Matrix3Xd& Q, double& length_m);

    /// Posterior covariance of the control points (3K x 3K, point by point) and variance of the length, at
    /// the solution. False when something is not determined at all.
    bool covariance(const CurveProblem& problem, const Eigen::Matrix3Xd& Q, double length_m,
                    Eigen::MatrixXd& covariance, double& length_variance);

    /// The part of the covariance of both ends that the images' noise alone makes, with the other terms taken
    /// for true; `covariance` is that of the solution, as above.
    Matrix6d noise_of_ends(const CurveProblem& problem, const Eigen::Matrix3Xd& Q,
                           const Eigen::MatrixXd& covariance) const;

    /// How the solution moves with what the right eye is off by: d Q / d (row, roll), 3K x 2.
    Eigen::MatrixX2d by_eye(const CurveProblem& problem, const Eigen::Matrix3Xd& Q,
                            const Eigen::MatrixXd& covariance) const;

  private:
    /// A line's residual and its derivative by the point in C.
    struct LineTerm {
        double r_px;
        Eigen::RowVector3d by_point;
    };
    std::optional<LineTerm> line_term(const LineMeasurement& line, std::size_t eye, std::size_t sample,
                                      const Eigen::Matrix3Xd& Q) const;
    template <typename Visit>
    int for_each_seen(const CurveProblem& problem, const Eigen::Matrix3Xd& Q, Visit&& visit) const;
    double accumulate(const CurveProblem& problem, const Eigen::Matrix3Xd& Q, double length_m,
                      bool normal_equations);
    double add_lines(const CurveProblem& problem, const Eigen::Matrix3Xd& Q, bool normal_equations);
    double add_length(const CurveProblem& problem, const Eigen::Matrix3Xd& Q, double length_m,
                      bool normal_equations);
    double add_bending(const CurveProblem& problem, const Eigen::Matrix3Xd& Q, double length_m,
                       bool normal_equations);
    double add_points(const CurveProblem& problem, const Eigen::Matrix3Xd& Q, bool normal_equations);
    double add_end(int k, const EndPrior& prior, const Eigen::Matrix3Xd& Q, bool normal_equations);
    double add_deformation(const CurveProblem& problem, const Eigen::Matrix3Xd& Q, bool normal_equations);
    double cost(const CurveProblem& problem, const Eigen::Matrix3Xd& Q, double length_m,
                bool normal_equations);
    double add_point(int k, const Eigen::Vector3d& error, double weight, bool normal_equations);

    CurvePriors priors_;
    scenes::StereoRig rig_;
    CubicBasis basis_;
    std::vector<CubicBasisValues> samples_;
    std::vector<CubicBasisValues> knots_;
    std::vector<CubicBasisValues> spans_;  ///< third derivatives, in `second_derivative`
    BorderedBandSystem system_;
    Eigen::VectorXd step_;
    Eigen::Matrix3Xd trial_;
    std::vector<double> seen_bends_;        ///< at each place of a bending term, and one before and behind
    Eigen::VectorXd offset_, unexplained_;  ///< of the control points from their prediction
};

}  // namespace atropos::tracker
