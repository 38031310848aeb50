#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "scenes/capsule.hpp"
#include "scenes/polyline.hpp"
#include "scenes/stereo_rig.hpp"
#include "tests/support/background.hpp"
#include "tests/support/inextensible_curve.hpp"

namespace atropos::support {

/// What is drawn (method.md, III-A).
enum class Protocol {
    kP,  ///< the truth is a spline of 8 control points with the jitter of a track, as in the paper
    kS,  ///< the truth is the inextensible curve itself
};

struct SyntheticSequenceOptions {
    std::uint64_t seed = 1;
    Protocol protocol = Protocol::kS;
    scenes::StereoRig rig = scenes::parallel_rig(640, 360, 575.0, 0.005);
    double depth_m = 0.100;     ///< of the thread's middle
    int acceleration = 1;       ///< every n-th frame of the first sequence
    double motion_scale = 1.0;  ///< 1: about 0.45 px a frame of smooth motion at acceleration 1
    double length_m = 0.070;
    double width_m = 0.00035;
    std::optional<double> heading_rad =
        {};  ///< of the chord; unset: drawn from the seed; 0 = along the baseline
    std::optional<double> turning_rad = {};   ///< total turn of the resting arc; unset: drawn
    std::optional<double> arc_tilt_rad = {};  ///< unset: drawn; pi/2 = all sag in depth
    double turning_share = 1.0;               ///< as of the curve: with a turning of 4 to 5, a loop
    double turning_swing_rad = 0.0;           ///< as of the curve: a loop that is formed and undone
    double travel_share = 0.0;                ///< as of the curve: a loop that travels along the thread
    bool dark = true;
    double contrast = 60.0;     ///< grey levels between thread and background
    double noise_levels = 4.0;  ///< standard deviation
    double blur_px = 0.6;       ///< standard deviation of the optics
    bool clutter = true;
    bool instruments = true;  ///< two shafts that hide the last 1.5 mm of each end
    bool free_end = false;    ///< nothing holds end 1
    double hidden_end_m = 0.0015;
    double tip_error_m = 0.0;      ///< measured ends off by up to this much, constant over the sequence
    double tip_jitter_m = 0.0;     ///< and by this much (each axis), new in each frame
    bool jaws = false;             ///< instruments grip across the thread instead of lying along it
    double paid_out_m = 0.0;       ///< of thread a frame of the first sequence, at end 1; 15 % at most
    double tail_m = 0.0;           ///< thread beyond each grip
    double jaw_excess_m = 0.0003;  ///< jaws are drawn this much wider than their capsules, and lopsided
    int occlusion_begin = -1;      ///< first frame in which a third shaft crosses the thread; -1 = never
    int occlusion_frames = 30;
    double occluded_share = 0.3;  ///< of the thread's length
};

/// The thread's rest and motion: what the options leave unset is drawn from the seed.
InextensibleCurveOptions curve_options(const SyntheticSequenceOptions& options);

struct SyntheticFrame {
    double time_s = 0.0;
    cv::Mat1b left;
    cv::Mat1b right;
    scenes::Polyline truth_C;                    ///< m
    std::array<Eigen::Vector3d, 2> tips_C;       ///< measured
    std::vector<scenes::Capsule> instruments_C;  ///< measured: off as the end that they hold
};

/// The thread alone: a polyline for every frame.
class SyntheticThread {
  public:
    explicit SyntheticThread(const SyntheticSequenceOptions& options);

    scenes::Polyline truth(int index) const;

  private:
    SyntheticSequenceOptions options_;
    InextensibleCurve curve_;
};

/// Images of a moving thread with exact truth, from formulae alone: anti-aliased lines over a cluttered wall.
/// Frame i depends on nothing but the options and i.
class SyntheticSequence {
  public:
    explicit SyntheticSequence(const SyntheticSequenceOptions& options);

    SyntheticFrame frame(int index) const;
    scenes::Polyline truth(int index) const { return thread_.truth(index); }
    const SyntheticSequenceOptions& options() const { return options_; }

  private:
    std::vector<scenes::Capsule> shafts(const scenes::Polyline& thread, int index) const;
    scenes::Capsule jaw(const scenes::Polyline& thread, int end) const;
    scenes::Polyline with_tails(const scenes::Polyline& thread) const;
    cv::Mat1b draw(int eye, int index, const scenes::Polyline& thread,
                   const std::vector<scenes::Capsule>& shafts) const;

    SyntheticSequenceOptions options_;
    SyntheticThread thread_;
    std::array<cv::Mat1f, 2> background_;
    std::vector<float> noise_;
    std::array<Eigen::Vector3d, 2> tip_error_;
};

}  // namespace atropos::support
