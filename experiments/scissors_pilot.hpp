#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "experiments/arm_reading.hpp"
#include "experiments/instrument_sights.hpp"
#include "robot/scissors_command.hpp"
#include "scenes/scene_config.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::experiments {

/// Makes a tracker for its rig.
using TrackerMaker = std::function<std::unique_ptr<tracker::StereoTracker>(const scenes::StereoRig&)>;

/// Takes the place of what the tracker says: null controllers.
using EstimateSubstitute = std::function<scenes::ThreadEstimate(const scenes::ThreadEstimate&)>;

/// All that decides in the closed loop: finds instruments and thread in the images and commands the scissors.
/// It is given images, calibration and measured poses and has no way to anything else; fed the same again,
/// it commands the same.
class ScissorsPilot {
  public:
    /// `scissors` is the controller of the third arm. Null `make_tracker`: the scene's own.
    ScissorsPilot(const scenes::SceneConfig& scene, const scenes::StereoRig& rig, const ArmReadings& arms,
                  const InstrumentModels& instruments, robot::PsmArm& scissors,
                  const TrackerMaker& make_tracker = nullptr);

    void substitute(EstimateSubstitute substitute) { substitute_ = std::move(substitute); }
    /// Ends told to the tracker in place of the measured grips.
    void tell_tips(const std::array<Eigen::Vector3d, 2>& tips_C) { told_tips_C_ = tips_C; }

    /// A pair of pictures taken now. What the tracker makes of it; null when it does not take this frame.
    const tracker::TrackResult* see(int frame, double time_s, const cv::Mat& left, const cv::Mat& right,
                                    const ArmReadings& arms);

    /// Once a millisecond: commands the scissors.
    void step(double time_s, const ArmReadings& arms);

    const robot::ScissorsStatus& status() const { return command_->status(); }
    const tracker::StereoTracker& tracker() const { return *tracker_; }
    const InstrumentSights* sights() const { return sights_.get(); }  ///< null: the arms are exact

  private:
    /// What the images said, on its way to the command.
    struct Message {
        double arrives_s;
        scenes::ThreadEstimate estimate;
        std::array<std::optional<robot::InstrumentOffset>, kArms> offsets;
        std::optional<robot::CutCheck> cut_check;
    };
    void look_at_instruments(tracker::StereoFrame& frame, const ArmReadings& arms);
    void remember_whole(const tracker::StereoFrame& frame, const scenes::ThreadEstimate& estimate);
    scenes::ThreadEstimate carried(const tracker::StereoFrame& frame) const;
    std::optional<robot::CutCheck> check_cut(const tracker::StereoFrame& frame,
                                             const scenes::ThreadEstimate& estimate) const;
    robot::ScissorsInput input(double time_s, const ArmReadings& arms);

    scenes::SceneConfig scene_;
    scenes::StereoRig rig_;
    std::unique_ptr<tracker::StereoTracker> tracker_;
    std::unique_ptr<robot::ScissorsCommand> command_;
    std::unique_ptr<InstrumentSights> sights_;
    EstimateSubstitute substitute_;
    std::optional<std::array<Eigen::Vector3d, 2>> told_tips_C_;
    std::vector<Message> under_way_;
    std::optional<Message> arrived_;
    /// The thread when it was last seen whole, before the blades closed.
    struct Whole {
        scenes::ThreadEstimate estimate;
        std::array<std::optional<tracker::MeasuredTip>, 2> tips;
        double contrast_levels = 0.0;
    } whole_;
    std::array<Eigen::Vector3d, 2> offsets_C_m_{Eigen::Vector3d::Zero(),
                                                Eigen::Vector3d::Zero()};  ///< of the holders, as last seen
    std::vector<scenes::Capsule> others_C_;
    double next_track_s_ = 0.0;
};

/// The command's options from the scene's keys.
robot::ScissorsOptions scissors_options(const scenes::SceneConfig& scene);

}  // namespace atropos::experiments
