#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "render/stereo_frame.hpp"
#include "scenes/stereo_rig.hpp"
#include "scenes/worker_pool.hpp"

namespace atropos::render {

/// From linear light to the pictures a camera control unit gives. In this order: exposure and vignetting,
/// noise, gain, response curve, 8 bits, compression. Lens distortion and point spread are the endoscope's.
struct SensorOptions {
    double exposure = 1.0;         ///< factor on the light
    bool auto_gain = false;        ///< bring the mean of both images to `gain_target`
    double gain_target = 0.16;     ///< mean linear value
    double gain_max = 4.0;         ///< own choice; 1 / gain_max is the least gain
    double vignetting = 0.0;       ///< 0 none, 1 the natural cos^4 law (Szeliski, Computer Vision, 2.2.3)
    double read_noise = 0.0;       ///< sigma in the dark, of full scale: 0.006 as in rendering.md section 8
    double shot_noise = 0.0;       ///< growth of the variance at full scale, in read-noise variances: 9
    int jpeg_quality = 0;          ///< 1-100: compressed and decompressed; 0 off
    double exposure_time_s = 0.0;  ///< > 0: motion blur over this time, which ends with the frame
    int motion_samples = 4;        ///< instants averaged for motion blur
    /// The left eye is this much older: the cameras of a da Vinci aren't synchronised by hardware.
    double right_eye_delay_s = 0.0;
};

/// `ideal`: the light itself in 8 bits, sRGB-coded. `realistic`: everything but time: vignetting, auto-gain,
/// noise and mild compression. Throws std::invalid_argument for other names.
SensorOptions sensor_preset(const std::string& name);

struct StereoImages {
    cv::Mat left;  ///< CV_8UC3, B G R
    cv::Mat right;
};

/// Stateless: a frame's noise is a hash of (pixel, channel, frame, eye, seed), so that any frame can be made
/// alone.
class Sensor {
  public:
    /// Throws std::invalid_argument for options out of range.
    Sensor(const SensorOptions& options, const scenes::StereoRig& rig, std::uint64_t seed);

    /// `pool`: threads that share the work; null: the caller's alone.
    StereoImages develop(const StereoFrame& frame, std::int64_t frame_index,
                         scenes::WorkerPool* pool = nullptr) const;

    /// When to render an eye (0 left, 1 right) for a frame that is read out at `time_s`: never later. Average
    /// the frames with `mean_exposure`.
    std::vector<double> exposure_times_s(double time_s, int eye) const;

  private:
    float gain(const StereoFrame& frame) const;
    cv::Mat develop_eye(const cv::Mat& linear, const cv::Mat& lens, float gain,
                        std::uint32_t noise_key) const;

    SensorOptions options_;
    std::uint64_t seed_;
    cv::Mat lens_left_, lens_right_;  // light that arrives at each pixel, exposure included
    std::vector<std::uint8_t> response_;
};

/// Light and coverage averaged over frames of one exposure; depth, labels and samples of the middle one.
StereoFrame mean_exposure(std::span<const StereoFrame> frames);

}  // namespace atropos::render
