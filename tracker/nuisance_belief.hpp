#pragma once

#include <vector>

#include "scenes/tracker_config.hpp"
#include "tracker/nuisances.hpp"
#include "tracker/slow_belief.hpp"

namespace atropos::tracker {

/// What is believed of arms, right eye and length, from frame to frame, together: an eye that is off by a row
/// and an arm that is off by a millimetre explain the same pictures, and filters of their own would each
/// learn from what the other has made of them.
///
/// One frame shows the eye's rows where the thread runs along them: there its rows in both eyes must agree,
/// whatever its depth. Elsewhere they are exchanged for depth, and only length, bending and ends tell.
class NuisanceBelief {
  public:
    /// `scale`: the pictures' width over 640.
    NuisanceBelief(const scenes::TrackerConfig& config, double scale);

    void reset();
    /// From now on a length that a start has measured, unless one is given. What is given may still be wrong.
    void expect_length(double measured_m);
    void wait(double dt_s) { belief_.wait(dt_s); }

    NuisancePrior prior() const;
    /// If whatever was given is wrong: for the first look, which is to tell.
    NuisancePrior doubting_prior() const;
    Nuisances mean() const { return Nuisances::from(belief_.mean()); }
    Nuisances::Matrix covariance() const { return belief_.covariance(); }

    /// From a fit that was told `told`; `covariance` and what `noise` makes of it.
    void learn(const NuisancePrior& told, const Nuisances& fitted, const Nuisances::Matrix& covariance,
               const Nuisances::Matrix& by_noise);

    static constexpr int kStateSize = SlowBelief<Nuisances::kCount>::kStateSize;
    double* save(double* out) const { return belief_.save(out); }
    const double* load(const double* in);

  private:
    using Belief = SlowBelief<Nuisances::kCount>;

    scenes::TrackerConfig::Refined config_;
    double given_length_m_;  ///< 0: none
    double scale_;
    Belief belief_;
};

}  // namespace atropos::tracker
