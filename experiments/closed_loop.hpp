#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiments/endoscope_view.hpp"
#include "experiments/instrument_sight.hpp"
#include "experiments/stage_clock.hpp"
#include "experiments/testbed.hpp"
#include "robot/scissors_command.hpp"
#include "scenes/scene_config.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::experiments {

/// What one camera frame of the loop leaves behind. The references live during the call only.
struct LoopFrame {
    int frame;
    const View& view;
    const tracker::TrackResult* tracked;  ///< of this frame; null when the tracker does not take it
    const robot::ScissorsStatus& command;
};

/// Simulation at 1 kHz, camera at its rate, tracker at its own rate and simulated latency, scissors command:
/// one episode. Results never depend on the machine's speed. The tracker gets images, calibration and
/// measured poses; the command gets estimates and measured poses; the truth goes to the observer alone.
class ClosedLoop {
  public:
    using Observer = std::function<void(const LoopFrame&)>;

    /// Makes the tracker of the loop for its rig; null: the scene's own.
    using TrackerMaker = std::function<std::unique_ptr<tracker::StereoTracker>(const scenes::StereoRig&)>;

    explicit ClosedLoop(const scenes::SceneConfig& scene, const TrackerMaker& make_tracker = nullptr);
    ~ClosedLoop();

    /// Runs to the end: the command has finished and a little longer, or the scene's duration is over.
    void run(const Observer& observer);

    const Testbed& testbed() const { return testbed_; }
    const robot::ScissorsStatus& status() const { return command_->status(); }
    const InstrumentSights* sights() const { return sights_.get(); }  ///< null: the arms are exact
    const tracker::StereoTracker& tracker() const { return *tracker_; }
    const StageClock& clock() const { return clock_; }
    long frames() const;  ///< at most, over the scene's duration

  private:
    struct Pending {
        double arrives_s;
        scenes::ThreadEstimate estimate;
        std::array<std::optional<robot::InstrumentOffset>, kArms> offsets;
        std::optional<robot::CutCheck> cut_check;
    };
    void look(int frame, const Observer& observer);
    tracker::StereoFrame tracker_frame(int frame, const View& view);
    void look_at_instruments(tracker::StereoFrame& frame);
    Eigen::Vector3d seen_grip_C(int end) const;
    std::optional<robot::CutCheck> check_cut(const tracker::StereoFrame& frame);
    scenes::ThreadEstimate delivered(const scenes::ThreadEstimate& estimate);
    robot::ScissorsInput scissors_input();

    scenes::SceneConfig scene_;
    Testbed testbed_;
    EndoscopeView endoscope_;
    std::unique_ptr<tracker::StereoTracker> tracker_;
    std::unique_ptr<robot::ScissorsCommand> command_;
    std::unique_ptr<InstrumentSights> sights_;  ///< null: the arms are exact
    std::vector<Pending> pending_;
    std::optional<Pending> arrived_;
    scenes::ThreadEstimate before_close_;  ///< the last estimate before the blades closed
    std::optional<scenes::ThreadEstimate> frozen_;
    std::vector<scenes::Capsule> others_C_;
    double next_track_s_ = 0.0;
    StageClock clock_;
};

/// The command's options from the scene's keys.
robot::ScissorsOptions scissors_options(const scenes::SceneConfig& scene);

}  // namespace atropos::experiments
