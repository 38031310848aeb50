#pragma once

#include <Eigen/Core>

namespace atropos::tracker {

/// How threads deform from frame to frame beyond what is predicted, learned from recorded tracks: the first
/// modes of a principal component analysis, and one deviation for all that is not in them (Tipping and Bishop
/// 1999). In the thread's own frame, see `thread_frame`.
struct DeformationPrior {
    int control_points = 0;       ///< K
    double frame_rate_hz = 30.0;  ///< of the tracks; deviations grow with the time between frames
    int tracks = 0, frames = 0;   ///< that it was learned from
    Eigen::MatrixXd modes;        ///< 3K x M, orthonormal columns, point by point
    Eigen::VectorXd sigmas_m;     ///< of the modes' amplitudes, falling
    double rest_sigma_m = 0.0;    ///< of every other direction

    int count() const { return static_cast<int>(sigmas_m.size()); }
};

/// Throws std::invalid_argument when `prior` is none: sizes that disagree, modes that are not orthonormal,
/// deviations that are not positive.
void validate(const DeformationPrior& prior);

/// Axes, as columns, in which threads of all scenes deform alike: x along the chord of the curve's ends, y to
/// the side to which the curve sags, z across. A hanging thread sags along gravity and one on stiff jaws in
/// the plane that they give it: the curve itself shows which, where neither camera nor gravity would. Where
/// it is straight, y is away from the camera.
Eigen::Matrix3d thread_frame(const Eigen::Matrix3Xd& Q);

/// A prior's modes as one frame needs them: in C, deviations for its time step.
struct DeformationModes {
    Eigen::MatrixXd V;         ///< 3K x M, orthonormal
    Eigen::VectorXd sigmas_m;  ///< M
    double rest_sigma_m = 0.0;
    double weight = 1.0;

    bool empty() const { return sigmas_m.size() == 0; }

    /// Of an offset of all control points from their prediction (3K): its likeliest amplitudes when the rest
    /// is noise.
    Eigen::VectorXd amplitudes(const Eigen::VectorXd& offset) const;

    /// Cost of the offset, half its squared Mahalanobis distance for small ones; and `shrunk`, the part of it
    /// that the modes do not explain, and `information` of that part, for normal equations. Multivariate t of
    /// four degrees of freedom (Lange, Little, Taylor 1989): how threads deform carries over between scenes,
    /// how fast does not.
    double cost(const Eigen::VectorXd& offset, Eigen::VectorXd& shrunk, double& information) const;
};

/// `Q`: the curve that deforms; `dt_s` since the frame that it was predicted from.
DeformationModes placed(const DeformationPrior& prior, const Eigen::Matrix3Xd& Q, double dt_s);

}  // namespace atropos::tracker
