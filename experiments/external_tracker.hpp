#pragma once

#include <functional>
#include <memory>
#include <string>

#include "experiments/child_process.hpp"
#include "scenes/stereo_rig.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::experiments {

struct ExternalTrackerOptions {
    std::string command;      ///< for /bin/sh
    double timeout_s = 10.0;  ///< for one frame, by the wall clock; the start of the command included
    int restarts = 3;         ///< in a row without one good answer; then it is given up
};

/// Somebody's tracker as a lock-step child process (docs/own_tracker.md): a JSON line and raw pixels in, a
/// JSON line out. Whatever the child does costs its frames only: they are lost, with a line in the log, and
/// the child is started anew when it ended or hangs.
class ExternalTracker final : public tracker::StereoTracker {
  public:
    using Log = std::function<void(const std::string& line)>;

    ExternalTracker(ExternalTrackerOptions options, scenes::StereoRig rig, Log log);

    const tracker::TrackResult& start(const tracker::StereoFrame& frame,
                                      const tracker::NurbsCurve& initial) override;
    const tracker::TrackResult& track(const tracker::StereoFrame& frame) override;
    const tracker::StageTimings& timings() const override { return timings_; }
    tracker::TrackerState state() const override;
    void restore(const tracker::TrackerState& state) override;  ///< throws: the child keeps its own state
    void set_observer(tracker::TrackObserver*) override {}      ///< nothing to look into

  private:
    const tracker::TrackResult& exchange(const tracker::StereoFrame& frame, const std::string& request);
    bool ask(const tracker::StereoFrame& frame, const std::string& request);
    bool accept(const std::string& line);
    bool lost(const std::string& why, bool end_child);

    ExternalTrackerOptions options_;
    scenes::StereoRig rig_;
    Log log_;
    std::string calibration_;
    std::unique_ptr<ChildProcess> child_;
    int bad_starts_ = 0;
    tracker::TrackResult result_;
    tracker::StageTimings timings_;
};

/// The tracker of `options`; its log lines go to `log`, which must outlive it, and to stderr unless quiet.
std::unique_ptr<tracker::StereoTracker> make_external_tracker(const ExternalTrackerOptions& options,
                                                              const scenes::StereoRig& rig, std::string& log,
                                                              bool quiet);

}  // namespace atropos::experiments
