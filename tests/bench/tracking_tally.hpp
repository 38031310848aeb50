#pragma once

#include <vector>

#include "scenes/polyline.hpp"
#include "scenes/stereo_rig.hpp"
#include "scenes/thread_estimate.hpp"

namespace atropos::bench {

/// Many values of one kind.
class Values {
  public:
    void add(double value) { values_.push_back(value); }
    void add(const Values& other) {
        values_.insert(values_.end(), other.values_.begin(), other.values_.end());
    }
    double last() const { return values_.empty() ? 0.0 : values_.back(); }
    double mean() const;                  ///< 0 of none
    double quantile(double share) const;  ///< 0 of none
    double percent_below(double limit) const;

  private:
    std::vector<double> values_;
};

/// How a tracker did over the frames of a row. Errors as the paper's (eq. 20-22), lost frames left out; a
/// frame failed when it is lost or its 2D error exceeds 5 px at 640; it failed silently when its 2D error
/// exceeds 5 px or its 3D error 3 mm while the status says tracking.
class TrackingTally {
  public:
    Values error_mm, symmetric_mm, error_px, middle_mm, frame_ms;
    Values depth_sigmas, lateral_sigmas, along_sigmas;  ///< offsets over their stated sigmas, per sample
    int frames = 0, failed = 0, events = 0, silent = 0, lost = 0, coasting = 0;

    void begin_sequence() { failed_before_ = false; }
    /// Whether the frame failed.
    bool add(const scenes::ThreadEstimate& estimate, const scenes::Polyline& truth_C,
             const scenes::StereoRig& rig);

    double failed_percent() const { return frames > 0 ? 100.0 * failed / frames : 0.0; }
    double silent_percent() const { return frames > 0 ? 100.0 * silent / frames : 0.0; }

  private:
    bool count(bool frame_failed);

    bool failed_before_ = false;
};

}  // namespace atropos::bench
