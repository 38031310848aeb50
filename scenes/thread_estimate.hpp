#pragma once

#include <Eigen/Core>
#include <vector>

namespace atropos::scenes {

/// What a tracker says of itself in one frame.
enum class TrackStatus {
    kTracking,  ///< the curve is seen
    kCoasting,  ///< the curve is carried on by motion and length, hardly seen
    kLost,      ///< there is no curve
};

/// One point of an estimated thread, in the left camera's frame C.
struct ThreadSample {
    double s_m = 0.0;                               ///< arc length from end 0
    Eigen::Vector3d p_C = Eigen::Vector3d::Zero();  ///< m
    double sigma_lateral_m = 0.0;                   ///< one sigma across the viewing ray
    double sigma_depth_m = 0.0;                     ///< one sigma along the viewing ray
    double sigma_along_m = 0.0;  ///< one sigma along the thread: how far it may have slid at this arc length
};

/// The thread's span between its two ends as a tracker sees it. The only thing the scissors command gets from
/// a tracker.
struct ThreadEstimate {
    double capture_time_s = 0.0;  ///< when the images were taken, not when the estimate was ready
    TrackStatus status = TrackStatus::kLost;
    double confidence =
        0.0;  ///< probability in [0, 1] that no sample is further off than the failure threshold
    std::vector<ThreadSample> samples;  ///< equal steps of arc length, end 0 first; empty when lost

    double length_m() const { return samples.empty() ? 0.0 : samples.back().s_m; }
};

/// "tracking", "coasting", "lost": the words of the track's frames.csv.
const char* to_string(TrackStatus status);

}  // namespace atropos::scenes
