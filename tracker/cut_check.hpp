#pragma once

#include <span>

#include "scenes/stereo_rig.hpp"
#include "scenes/thread_estimate.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::tracker {

enum class CutVerdict {
    kIntact,   ///< a thread passes through the place
    kCut,      ///< the place is seen, and no thread passes
    kUnknown,  ///< too little of it is seen
};

const char* to_string(CutVerdict verdict);  ///< "intact", "cut", "unknown"

struct CutCheckOptions {
    double width_m = 0.00035;  ///< of the thread
    scenes::ThreadPolarity polarity = scenes::ThreadPolarity::kDark;
    scenes::ImageChannel channel = scenes::ImageChannel::kGray;
    double contrast_levels = 4.0;
    double usual_levels = 0.0;  ///< contrast of the thread when it was whole; 0: as on both sides now
    double reach_m = 0.006;     ///< looked at on each side of the place
    double near_m = 0.002;      ///< of it, what a cut opens
    double search_m = 0.0025;   ///< the thread may have moved so far from the estimate
    double instrument_sigma_m = 0.0007;  ///< what an instrument hides, grown by two sigma, counts as unseen
    double least_visible = 0.6;          ///< share of the place that must be seen for a verdict
    double intact_support = 0.8;         ///< supported share of what is seen, from which the thread passes
    double cut_support = 0.35;           ///< and up to which it does not
    double side_support = 0.5;           ///< an intact thread has on both sides, as far as they are seen
};

struct CutCheck {
    CutVerdict verdict = CutVerdict::kUnknown;
    double visible = 0.0;         ///< share of the samples near the place that both eyes see
    double support_at = 0.0;      ///< supported share of the visible samples near the place
    double support_before = 0.0;  ///< on the side of end 0
    double support_after = 0.0;   ///< on the side of end 1
    double usual_levels = 0.0;    ///< contrast of the thread, here or as given
};

/// Looks in both eyes whether a thread still passes through the place of a commanded cut: valleys across the
/// estimate around arc length `s_m`, that both eyes must agree on. `estimate` is of the frame or of one
/// shortly before. Frames in which the blades still cover the place give `kUnknown`: ask again.
CutCheck check_cut(const StereoFrame& frame, const scenes::StereoRig& rig,
                   const scenes::ThreadEstimate& estimate, double s_m, const CutCheckOptions& options = {});

}  // namespace atropos::tracker
