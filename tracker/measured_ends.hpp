#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "scenes/capsule.hpp"
#include "scenes/stereo_rig.hpp"
#include "scenes/tracker_config.hpp"
#include "tracker/curve_refinement.hpp"
#include "tracker/end_belief.hpp"
#include "tracker/grip_sight.hpp"
#include "tracker/stereo_tracker.hpp"
#include "tracker/valley_filter.hpp"

namespace atropos::tracker {

/// The curve's ends as the arms measure them, without what each arm is known to be off by, and as the images
/// show where jaws hide the thread: the priors of a fit's ends, and what the fit teaches of the arms.
class MeasuredEnds {
  public:
    MeasuredEnds(const scenes::TrackerConfig& config, const scenes::StereoRig& rig,
                 const ValleyFilterOptions& filter);

    /// Other cameras from now on.
    void set_rig(const scenes::StereoRig& rig) { grip_sight_.set_rig(rig); }

    /// Forgets what the arms are off by.
    void reset();
    /// Forgets where the ends were measured last.
    void forget_motion() { last_tips_C_ = {}; }

    /// How far each end was measured to move since the last frame; that is free of a constant error.
    std::array<Eigen::Vector3d, 2> motion(const StereoFrame& frame) const;

    void wait(double dt_s);

    /// The frame's instruments; one that holds an end is wrong by as much as the end.
    void place(const StereoFrame& frame, std::vector<scenes::Capsule>& instruments_C) const;

    /// Where the ends are expected, into `problem`.
    void expect(const StereoFrame& frame, CurveProblem& problem);

    /// The same and where along the fitted thread the jaws are seen.
    void look(const StereoFrame& frame, const std::array<ImageView, 2>& images, const CubicBasis& basis,
              const Eigen::Matrix3Xd& Q, double length_m, CurveProblem& problem);

    /// What a good fit of the frame says of the arms' errors.
    void learn(const StereoFrame& frame, const CurveProblem& problem, const CurveRefinement& refinement,
               const Eigen::Matrix3Xd& Q, const Eigen::MatrixXd& covariance);

    /// How far the held end that is farthest from where it was measured is from there; 0 without held ends.
    static double farthest_m(const StereoFrame& frame, const Eigen::Matrix3Xd& Q);

    void remember(const StereoFrame& frame);

    static constexpr int kStateSize = 2 * (4 + EndBelief::kStateSize);
    void save(double* out) const;
    void load(const double* in);

  private:
    std::array<EndBelief, 2> beliefs_;
    GripSight grip_sight_;
    std::array<std::optional<Eigen::Vector3d>, 2> last_tips_C_;

    // Of the frame.
    std::array<UncertainPoint, 2> expected_;
    std::array<std::optional<GripSighting>, 2> grips_;
};

}  // namespace atropos::tracker
