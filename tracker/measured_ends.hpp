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
#include "tracker/grip_sight.hpp"
#include "tracker/nuisances.hpp"
#include "tracker/stereo_tracker.hpp"
#include "tracker/valley_filter.hpp"

namespace atropos::tracker {

/// The curve's ends as the arms measure them, without what each arm is known to be off by, and as the images
/// show where jaws hide the thread: the priors of a fit's ends, and what the fit teaches of the arms.
class MeasuredEnds {
  public:
    MeasuredEnds(const scenes::TrackerConfig& config, const ValleyFilterOptions& filter);

    /// Forgets how the jaws look.
    void reset() { jaws_.fill({}); }
    /// Forgets where the ends were measured last.
    void forget_motion() { last_tips_C_ = {}; }

    /// How far each end was measured to move since the last frame; that is free of a constant error.
    std::array<Eigen::Vector3d, 2> motion(const StereoFrame& frame) const;

    /// The frame's instruments; one that holds an end is wrong by as much as the end.
    static void place(const StereoFrame& frame, const Nuisances& expected,
                      std::vector<scenes::Capsule>& instruments_C);

    /// Where the ends are measured, into `problem`.
    void expect(const StereoFrame& frame, CurveProblem& problem) const;

    /// Where along the fitted thread the jaws are seen, into `problem`. `covariance` of the nuisances.
    void look(const StereoFrame& frame, const scenes::StereoRig& rig, const std::array<ImageView, 2>& images,
              const CubicBasis& basis, const FittedCurve& fit, const Nuisances::Matrix& covariance,
              CurveProblem& problem);

    /// From the look at a frame with a good fit.
    void learn();

    /// How far the held end that is farthest from where it was measured is from there; 0 without held ends.
    static double farthest_m(const StereoFrame& frame, const Eigen::Matrix3Xd& Q);

    void remember(const StereoFrame& frame);

    static constexpr int kStateSize = 2 * 6;
    void save(double* out) const;
    void load(const double* in);

  private:
    /// How much wider than their capsules an arm's jaws are seen on each side.
    struct JawExcess {
        double m = 0.0;
        double variance_m2 = kExcessSigma_m * kExcessSigma_m;
    };
    static constexpr double kExcessSigma_m = 0.0004;

    double jitter_sigma_m_;
    GripSight grip_sight_;
    std::array<JawExcess, 2> jaws_;
    std::array<std::optional<Eigen::Vector3d>, 2> last_tips_C_;
    std::array<std::optional<GripSighting>, 2> seen_;  ///< in the frame
};

}  // namespace atropos::tracker
