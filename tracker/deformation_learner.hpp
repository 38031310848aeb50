#pragma once

#include "tracker/deformation_prior.hpp"
#include "tracker/motion_prediction.hpp"

namespace atropos::tracker {

/// Learns a DeformationPrior from control points as they were tracked: the principal components of what they
/// did beyond their prediction, about no mean, for threads move to and fro. A thread's mirror image and the
/// thread from its other end deform alike, so each frame counts four times.
class DeformationLearner {
  public:
    explicit DeformationLearner(int control_points);

    /// The next frames are of another track, or come after a gap.
    void begin_track();

    /// Control points (3 x K, in C, m) of one frame, frame after frame. Throws std::invalid_argument for
    /// another K and for times that do not rise.
    void add(const Eigen::Matrix3Xd& Q, double time_s);

    int frames() const { return frames_; }  ///< that were compared with a prediction

    /// The first `modes`. Throws std::invalid_argument with fewer frames than 3K, and when the control points
    /// did nothing but what was predicted.
    DeformationPrior learn(int modes) const;

  private:
    int K_;
    int frames_ = 0, tracks_ = 0;
    double time_sum_s_ = 0.0;
    Eigen::MatrixXd scatter_;  ///< of displacements for a step of a second
    Eigen::Matrix3Xd last_;    ///< empty: none
    double last_time_s_ = 0.0;
    int followed_ = 0;  ///< frames of this track: the first has no velocity
    MotionPrediction motion_;
};

}  // namespace atropos::tracker
