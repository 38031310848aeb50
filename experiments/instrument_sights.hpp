#pragma once

#include <array>
#include <memory>
#include <vector>

#include "experiments/instrument_sight.hpp"
#include "scenes/scene_config.hpp"
#include "scenes/worker_pool.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::experiments {

using InstrumentModels = std::array<render::InstrumentModel, kArms>;

/// All instruments in both images, with the colours they share.
class InstrumentSights {
  public:
    InstrumentSights(const scenes::StereoRig& rig, const InstrumentModels& instruments,
                     const SightPrior& prior, int threads);
    InstrumentSights(const InstrumentSights&) = delete;
    InstrumentSights& operator=(const InstrumentSights&) = delete;

    /// Images are BGR, 8 bit.
    void look(const cv::Mat& left, const cv::Mat& right, const ArmReadings& arms);

    const InstrumentSight& operator[](int arm) const { return sights_[static_cast<size_t>(arm)]; }

  private:
    void label(size_t eye);
    void learn(size_t eye, const cv::Mat& image);

    scenes::StereoRig rig_;
    std::vector<InstrumentSight> sights_;
    std::array<InstrumentSight::EyeView, 2> eyes_;
    std::array<InstrumentColours, 2> colours_;
    scenes::WorkerPool pool_;
    long looks_ = 0;
};

/// How far arms of this accuracy may be off.
SightPrior sight_prior(scenes::ArmAccuracy accuracy);

/// Null for perfect arms: they are where they are measured.
std::unique_ptr<InstrumentSights> make_instrument_sights(scenes::ArmAccuracy accuracy,
                                                         const scenes::StereoRig& rig,
                                                         const InstrumentModels& instruments, int threads);

/// Finds the instruments in the frame's pictures (null `sights`: takes them as measured) and adds their
/// capsules to it. Returns each arm's grip point in C.
std::array<Eigen::Vector3d, kArms> add_instruments(InstrumentSights* sights, const ArmReadings& arms,
                                                   tracker::StereoFrame& frame);

}  // namespace atropos::experiments
