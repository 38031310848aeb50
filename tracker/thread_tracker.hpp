#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "tracker/discrete_search.hpp"
#include "tracker/estimate_sampler.hpp"
#include "tracker/image_unknowns.hpp"
#include "tracker/stereo_cost_images.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::tracker {

/// One standard deviation, at 640, that ThreadTracker states for its curves: what `config` says or, where
/// that is 0, its method's own.
scenes::TrackerConfig::Uncertainty stated_uncertainty(const scenes::TrackerConfig& config);

/// The paper's tracker: cost images of both eyes, then two steps of discrete optimisation of E1 or E2 over
/// the control points in space; or, as a comparison, over those of both image curves.
class ThreadTracker final : public StereoTracker {
  public:
    ThreadTracker(const scenes::TrackerConfig& config, const scenes::StereoRig& rig);

    const TrackResult& start(const StereoFrame& frame, const NurbsCurve& initial) override;
    const TrackResult& track(const StereoFrame& frame) override;
    const StageTimings& timings() const override { return timings_; }
    TrackerState state() const override;
    void restore(const TrackerState& state) override;
    void set_observer(TrackObserver* observer) override { observer_ = observer; }

    double label_spacing_m() const { return spacing_m_; }  ///< of the first step, once started

  private:
    void begin(const std::vector<Eigen::Vector3d>& control_points);
    void prepare_for_reference();
    bool begin_between_tips(const StereoFrame& frame);
    EnergyContext context(const StereoFrame& frame) const;
    void want_reached_pixels(const StereoFrame& frame);
    void optimise(const StereoFrame& frame);
    void judge(const StereoFrame& frame);
    const TrackResult& lost_result(const StereoFrame& frame);

    scenes::TrackerConfig config_;
    scenes::StereoRig rig_;
    std::array<Eye, 2> eyes_;
    CurveSampling sampling_;
    EnergyWeights weights_;
    scenes::WorkerPool pool_;
    DiscreteSearch search_;
    EstimateSampler sampler_;
    std::optional<StereoCostImages> cost_images_;
    std::optional<ImageUnknowns> image_unknowns_;  ///< 2D parameterisation only
    std::vector<double> reference_speed_m_;
    double spacing_m_ = 0.0;
    scenes::TrackerConfig::Uncertainty uncertainty_;
    TrackerState state_;
    TrackResult result_;
    StageTimings timings_;
    TrackObserver* observer_ = nullptr;
};

}  // namespace atropos::tracker
