#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "experiments/endoscope_view.hpp"
#include "experiments/scissors_pilot.hpp"
#include "experiments/stage_clock.hpp"
#include "experiments/testbed.hpp"

namespace atropos::experiments {

/// What happened at one camera frame. `tracked` and `command` are of the loop's own doing; `view.truth` and
/// the testbed are the judge's.
struct LoopFrame {
    int frame;
    const View& view;
    const tracker::TrackResult* tracked;  ///< of this frame; null when the tracker does not take it
    const robot::ScissorsStatus& command;
};

/// What the pilot was given and what it commanded in one millisecond.
struct LoopTick {
    double time_s;
    const ArmReadings& arms;
    const robot::PsmArm& scissors;
};

/// Simulation at 1 kHz, camera at its rate, tracker at its own rate and simulated latency, scissors command:
/// one episode. Results never depend on the machine's speed. The pilot gets images, calibration and measured
/// poses; the truth goes to the observers alone.
class ClosedLoop {
  public:
    using Observer = std::function<void(const LoopFrame&)>;
    using TickObserver = std::function<void(const LoopTick&)>;

    explicit ClosedLoop(const scenes::SceneConfig& scene, const TrackerMaker& make_tracker = nullptr);

    /// Runs to the end: the command has finished and a little longer, or the scene's duration is over.
    void run(const Observer& observer, const TickObserver& tick_observer = nullptr);

    const Testbed& testbed() const { return testbed_; }
    const robot::ScissorsStatus& status() const { return pilot_.status(); }
    const InstrumentSights* sights() const { return pilot_.sights(); }  ///< null: the arms are exact
    const tracker::StereoTracker& tracker() const { return pilot_.tracker(); }
    const StageClock& clock() const { return clock_; }
    long frames() const;  ///< at most, over the scene's duration

  private:
    void look(int frame, const Observer& observer);
    scenes::ThreadEstimate substituted(const scenes::ThreadEstimate& estimate);

    scenes::SceneConfig scene_;
    Testbed testbed_;
    EndoscopeView endoscope_;
    ScissorsPilot pilot_;
    std::optional<scenes::ThreadEstimate> frozen_;
    StageClock clock_;
};

}  // namespace atropos::experiments
