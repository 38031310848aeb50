#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "scenes/capsule.hpp"
#include "scenes/stereo_rig.hpp"
#include "scenes/thread_estimate.hpp"
#include "scenes/tracker_config.hpp"
#include "tracker/eye_correction.hpp"
#include "tracker/nurbs_curve.hpp"

namespace atropos::tracker {

/// Where an end of the thread is known to be, by the kinematics (II-F) or by sight.
struct MeasuredTip {
    enum class Kind {
        kHeld,   ///< by an instrument: approximate, eq. 19
        kFixed,  ///< does not move, such as a knot: the curve ends exactly there
        kSeen,   ///< found in these very pictures: no arm's error is in it
    };
    Eigen::Vector3d p_C = Eigen::Vector3d::Zero();  ///< m
    Kind kind = Kind::kHeld;
};

/// What is known at one instant: two images and, where measured, the ends and the instruments.
struct StereoFrame {
    std::int64_t index = 0;
    double capture_time_s = 0.0;
    cv::Mat left;   ///< 8 bit, gray or BGR, of the rig's size, as the camera saw it (distorted)
    cv::Mat right;  ///< the same
    std::array<std::optional<MeasuredTip>, 2> tips;  ///< of ends 0 and 1; nothing = unknown
    std::vector<scenes::Capsule> instruments;        ///< in C, measured: pixels behind them mean nothing
};

/// The terms of the energy at the curve found (eq. 4-7, 19); data in px of a 640 px wide image.
struct EnergyTerms {
    double data = 0.0;    ///< E_ext, eq. 5-6
    double length = 0.0;  ///< E_int, eq. 7, before its weight
    double tips = 0.0;    ///< E_tips, eq. 19, with its weight
    double stereo = 0.0;  ///< of the 2D parameterisation, with its weight
    double total = 0.0;   ///< eq. 4 and 19 with weights
};

/// Measured wall times of one frame, ms. Kept apart from the results, which repeat to the byte.
struct StageTimings {
    double cost_images_ms = 0.0;
    double potentials_ms = 0.0;
    double optimiser_ms = 0.0;
    double refinement_ms = 0.0;
    double total_ms = 0.0;
};

struct TrackResult {
    std::int64_t frame = 0;
    scenes::ThreadEstimate estimate;
    std::vector<Eigen::Vector3d> control_points;  ///< K points in C, m; empty when lost
    EnergyTerms energy;
    std::vector<int> labels;      ///< chosen label of node k in step j at [j * K + k]; 0 = no displacement
    double support = 0.0;         ///< share of the curve's samples, both eyes, that lie on a ridge
    bool length_refuted = false;  ///< the length that was given is not the thread's
    std::optional<EyeFound> eye;  ///< what the right eye is off by, where the tracker looks for it
};

/// All that a tracker carries from one frame to the next; restoring it repeats what followed to the byte.
struct TrackerState {
    bool started = false;
    scenes::TrackStatus status = scenes::TrackStatus::kLost;
    int frames_unseen = 0;
    double capture_time_s = 0.0;
    std::vector<Eigen::Vector3d> control_points;            ///< in C, m
    std::vector<Eigen::Vector3d> reference_control_points;  ///< curve of C'_ref (eq. 7)
    std::vector<double> method_state;                       ///< what the method keeps besides
};

/// Sees the steps inside a frame, for pictures and explanations. Called from the tracking thread, in order.
class TrackObserver {
  public:
    virtual ~TrackObserver() = default;

    /// `stage`: "gray", "ridge", "mask", "cost"; eye 0 = left. The image is valid during the call.
    virtual void image(std::string_view stage, int eye, const cv::Mat& picture) = 0;

    /// The curve after a step: "before", "step 0", "step 1", "refined"...
    virtual void curve(std::string_view stage, std::span<const Eigen::Vector3d> control_points) = 0;

    /// Label chosen and min-marginal cost of it per node, displacement in C (m).
    virtual void node(int step, int k, int label, const Eigen::Vector3d& displacement, double cost) = 0;
};

/// A tracker of one thread in stereo images.
class StereoTracker {
  public:
    virtual ~StereoTracker() = default;

    /// Begins with a known curve: tracks `frame` from it. Throws std::invalid_argument for bad frames, or a
    /// curve of another degree or number of control points than configured.
    virtual const TrackResult& start(const StereoFrame& frame, const NurbsCurve& initial) = 0;

    /// Tracks one frame. Before a start, and when both ends are measured, begins from the straight line
    /// between them (III); when they aren't, the result is lost. Throws std::invalid_argument for images of
    /// another size or type than the rig's, and for ends that are not finite or not before the camera. The
    /// result is valid until the next call.
    virtual const TrackResult& track(const StereoFrame& frame) = 0;

    virtual const StageTimings& timings() const = 0;  ///< of the last frame
    virtual TrackerState state() const = 0;

    /// Throws std::invalid_argument when the state does not fit the configuration.
    virtual void restore(const TrackerState& state) = 0;

    /// nullptr = nobody looks, the fast way.
    virtual void set_observer(TrackObserver* observer) = 0;
};

/// Throws std::invalid_argument that names the field and what it allows.
void validate(const scenes::TrackerConfig& config);

struct DeformationPrior;

/// The tracker that `config.method` names. `prior`: what `config.refined.prior_file` holds, which no tracker
/// reads itself; nullptr = none. Throws std::invalid_argument when one is named and not given, and for a
/// prior of another K.
std::unique_ptr<StereoTracker> make_tracker(const scenes::TrackerConfig& config, const scenes::StereoRig& rig,
                                            const DeformationPrior* prior = nullptr);

/// Throws std::invalid_argument unless images and tips of `frame` fit the rig: the check of every tracker.
void check_frame(const StereoFrame& frame, const scenes::StereoRig& rig);

}  // namespace atropos::tracker
