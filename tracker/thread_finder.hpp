#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "scenes/stereo_rig.hpp"
#include "scenes/thread_estimate.hpp"
#include "scenes/tracker_config.hpp"
#include "tracker/end_check.hpp"
#include "tracker/image_path.hpp"
#include "tracker/line_grower.hpp"
#include "tracker/line_linker.hpp"
#include "tracker/nurbs_curve.hpp"
#include "tracker/stereo_pairing.hpp"
#include "tracker/stereo_tracker.hpp"
#include "tracker/strand_search.hpp"

namespace atropos::tracker {

struct ThreadFinderOptions {
    scenes::ImageChannel channel = scenes::ImageChannel::kGray;
    RidgePointOptions ridge;
    LineLinkerOptions linker;
    StrandSearchOptions search;
    PairingOptions pairing;
    LineGrowerOptions grower;
    double largest_rival = 0.75;  ///< of the chosen line's weight, beyond which the choice is unsure
    double least_score = 0.8;     ///< of a fit that is sure
    EndCheckOptions end_check;
    double longest_level_px = 120.0;    ///< along the epipolar line
    double instrument_margin_px = 3.5;  ///< around the measured instruments, nothing is looked for
    double knot_spacing_px = 12.0;      ///< K follows from the thread's length in the image
    double line_sigma_px = 0.15;        ///< of a traced point
    double largest_row_offset_px = 2.0;
    double longest_tail_px = 15.0;    ///< of an end that one eye alone sees, unless the other's image ends
    double needle_width_ratio = 1.5;  ///< to the thread's median width, at an end: a needle
};

/// Why a found thread may not be the thread, or not the thread alone.
enum class Doubt {
    kNone,
    kLeap,   ///< it leaps in depth: runs on into another line
    kRival,  ///< another line is as likely the thread
    kEnd,    ///< the eyes don't agree where it ends
    kDepth,  ///< it runs along the epipolar line for long: its depth there, and so its length, are guesses
    kFit,    ///< no curve fits both eyes' lines
};

/// A thread found in one stereo frame.
struct FoundThread {
    NurbsCurve curve;                           ///< cubic, in C, m
    std::vector<scenes::ThreadSample> samples;  ///< 101 at equal steps of arc length, with sigmas
    double length_m = 0.0;
    double row_offset_px =
        0.0;                ///< rows of the right eye lie lower than calibrated, at the left focal length
    scenes::StereoRig rig;  ///< the rig with that offset: reprojects the curve to the right eye
    double score = 0.0;     ///< in [0, 1]: share of the curve seen in both eyes, times 1 / (1 + residual^2)
    double residual_px = 0.0;  ///< rms distance to the traced lines, both eyes
    std::array<ImagePath, 2> paths;
    Doubt doubt = Doubt::kNone;
};

/// Finds a thread with nothing known of it but that it is a thin line: ends, length and place are free. Ridge
/// points, paths, needle off, pairing along epipolar lines, triangulation, continuous refinement.
class ThreadFinder {
  public:
    explicit ThreadFinder(const scenes::StereoRig& rig, const ThreadFinderOptions& options = {});

    /// Images as a tracker gets them. The measured instruments, where there are any, are left out of the
    /// search; measured ends are not looked at. `seed_px`: a point of the left image near which the thread
    /// runs. Nothing when no thread is found in both eyes. Throws std::invalid_argument for images that don't
    /// fit the rig.
    std::optional<FoundThread> find(const StereoFrame& frame,
                                    const std::optional<Eigen::Vector2d>& seed_px = std::nullopt);

  private:
    void look(const StereoFrame& frame);
    std::optional<FoundThread> reconstruct(ImagePath left, ImagePath right, bool right_turned) const;

    scenes::StereoRig rig_;
    ThreadFinderOptions options_;
    RectifiedView view_;
    RidgePointDetector detector_;
    StrandSearch search_;
    std::array<EyeLines, 2> eyes_;
};

/// The options that fit a tracker's settings: polarity and channel of the thread.
ThreadFinderOptions finder_options(const scenes::TrackerConfig& config);

}  // namespace atropos::tracker
