#include "render/sensor.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "render/block_compression.hpp"
#include "scenes/random_stream.hpp"

namespace atropos::render {
namespace {

constexpr int kResponseSteps = 16384;  // an eighth of a level where the curve is steepest

std::vector<std::uint8_t> srgb_response() {
    std::vector<std::uint8_t> table(kResponseSteps);
    for (int i = 0; i < kResponseSteps; ++i) {
        const double v = static_cast<double>(i) / (kResponseSteps - 1);
        const double coded = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
        table[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(std::lround(255.0 * coded));
    }
    return table;
}

cv::Mat lens_map(const scenes::Camera& camera, const SensorOptions& o) {
    cv::Mat map(camera.height_px, camera.width_px, CV_32F);
    for (int y = 0; y < map.rows; ++y) {
        for (int x = 0; x < map.cols; ++x) {
            const double cos = o.vignetting > 0.0 ? camera.ray(Eigen::Vector2d(x, y)).z() : 1.0;
            map.at<float>(y, x) =
                static_cast<float>(o.exposure * (1.0 - o.vignetting * (1.0 - cos * cos * cos * cos)));
        }
    }
    return map;
}

// About standard normal: the sum of a hash's four bytes (Irwin and Hall), at most 3.45 sigma.
constexpr std::uint32_t kCounterStep = 0x9e3779b1u;

inline float noise(std::uint32_t h) {  // of counter * kCounterStep
    h = (h ^ (h >> 16)) * 0x7feb352du;
    h = (h ^ (h >> 15)) * 0x846ca68bu;
    h ^= h >> 16;
    const std::uint32_t pairs = (h & 0x00ff00ffu) + ((h >> 8) & 0x00ff00ffu);
    return (static_cast<float>(static_cast<std::int32_t>((pairs & 0xffffu) + (pairs >> 16))) - 510.0f) *
           (1.0f / 147.8f);
}

void validate(const SensorOptions& o) {
    const auto require = [](bool good, const char* message) {
        if (!good) throw std::invalid_argument(message);
    };
    require(o.exposure > 0.0, "sensor exposure isn't positive, expected a factor > 0");
    require(o.gain_target > 0.0 && o.gain_target < 1.0 && o.gain_max >= 1.0,
            "sensor gain out of range, expected a target in (0, 1) and gain_max >= 1");
    require(o.vignetting >= 0.0 && o.vignetting <= 1.0, "sensor vignetting out of range, expected [0, 1]");
    require(o.read_noise >= 0.0 && o.shot_noise >= 0.0, "sensor noise is negative, expected >= 0");
    require(o.jpeg_quality >= 0 && o.jpeg_quality <= 100,
            "sensor jpeg_quality out of range, expected 0 to 100");
    require(o.exposure_time_s >= 0.0 && o.motion_samples >= 1,
            "sensor exposure time out of range, expected >= 0 s in at least 1 sample");
}

}  // namespace

SensorOptions sensor_preset(const std::string& name) {
    SensorOptions options;
    if (name == "realistic") {
        options.auto_gain = true;
        options.vignetting = 1.0;
        options.read_noise = 0.006;
        options.shot_noise = 9.0;
        options.jpeg_quality = 92;
    } else if (name != "ideal") {
        throw std::invalid_argument("no sensor preset '" + name + "', expected ideal or realistic");
    }
    return options;
}

Sensor::Sensor(const SensorOptions& options, const scenes::StereoRig& rig, std::uint64_t seed)
    : options_(options),
      seed_(scenes::RandomStream(seed, "sensor noise").next()),
      response_(srgb_response()) {
    validate(options);
    lens_left_ = lens_map(rig.left, options);
    lens_right_ = lens_map(rig.right, options);
}

StereoImages Sensor::develop(const StereoFrame& frame, std::int64_t frame_index,
                             scenes::WorkerPool* pool) const {
    if (frame.left.linear.size() != lens_left_.size() || frame.right.linear.size() != lens_right_.size()) {
        throw std::invalid_argument("images differ from the sensor's rig in size, expected the rig's");
    }
    const std::uint64_t frame_seed = scenes::derive_seed(seed_, static_cast<std::uint64_t>(frame_index));
    const float g = gain(frame);
    StereoImages images;
    auto develop_one = [&](int eye) {
        if (eye == 0)
            images.left =
                develop_eye(frame.left.linear, lens_left_, g, static_cast<std::uint32_t>(frame_seed));
        else
            images.right =
                develop_eye(frame.right.linear, lens_right_, g, static_cast<std::uint32_t>(frame_seed >> 32));
    };
    if (pool)
        pool->run(2, develop_one);
    else
        for (const int eye : {0, 1}) develop_one(eye);
    return images;
}

float Sensor::gain(const StereoFrame& frame) const {
    if (!options_.auto_gain) return 1.0f;
    double sum = 0.0;
    std::int64_t count = 0;
    constexpr int kStride = 3;
    for (const auto& [linear, lens] :
         {std::pair(&frame.left.linear, &lens_left_), {&frame.right.linear, &lens_right_}}) {
        for (int y = 0; y < linear->rows; y += kStride) {
            const float *in = linear->ptr<float>(y), *arrives = lens->ptr<float>(y);
            for (int x = 0; x < linear->cols; x += kStride) {
                const float luma = 0.0722f * in[3 * x] + 0.7152f * in[3 * x + 1] + 0.2126f * in[3 * x + 2];
                sum += std::min(1.0f, luma * arrives[x]);
                ++count;
            }
        }
    }
    const double mean = std::max(sum / static_cast<double>(count), 1e-6);
    return static_cast<float>(
        std::clamp(options_.gain_target / mean, 1.0 / options_.gain_max, options_.gain_max));
}

cv::Mat Sensor::develop_eye(const cv::Mat& linear, const cv::Mat& lens, float gain,
                            std::uint32_t noise_key) const {
    cv::Mat image(linear.size(), CV_8UC3);
    const int values = 3 * linear.cols;
    const auto read2 = static_cast<float>(options_.read_noise * options_.read_noise);
    const auto shot = static_cast<float>(options_.shot_noise);
    std::vector<float> row(static_cast<std::size_t>(values));
    std::vector<std::int32_t> step(row.size());
    std::vector<std::uint32_t> counter(row.size());
    for (std::size_t i = 0; i < counter.size(); ++i)
        counter[i] = static_cast<std::uint32_t>(i) * kCounterStep;
    for (int y = 0; y < linear.rows; ++y) {
        const float *in = linear.ptr<float>(y), *arrives = lens.ptr<float>(y);
        for (int x = 0; x < linear.cols; ++x) {
            for (int c = 0; c < 3; ++c) row[static_cast<std::size_t>(3 * x + c)] = in[3 * x + c] * arrives[x];
        }
        if (read2 > 0.0f) {
            const std::uint32_t first = (noise_key + static_cast<std::uint32_t>(y * values)) * kCounterStep;
            for (int i = 0; i < values; ++i) {
                float& value = row[static_cast<std::size_t>(i)];
                const float light = std::min(std::max(value, 0.0f), 1.0f);
                value += std::sqrt(read2 * (1.0f + shot * light)) *
                         noise(first + counter[static_cast<std::size_t>(i)]);
            }
        }
        std::uint8_t* out = image.ptr<std::uint8_t>(y);
        for (int i = 0; i < values; ++i) {
            const float value = std::min(std::max(gain * row[static_cast<std::size_t>(i)], 0.0f), 1.0f);
            step[static_cast<std::size_t>(i)] =
                static_cast<std::int32_t>(value * (kResponseSteps - 1) + 0.5f);
        }
        const std::uint8_t* response = response_.data();
        const std::int32_t* steps = step.data();
        for (int i = 0; i < values; ++i) out[i] = response[steps[i]];
    }
    return options_.jpeg_quality == 0 ? image : compressed(image, options_.jpeg_quality);
}

std::vector<double> Sensor::exposure_times_s(double time_s, int eye) const {
    const double end_s = time_s - (eye == 0 ? options_.right_eye_delay_s : 0.0);
    if (options_.exposure_time_s <= 0.0) return {end_s};
    std::vector<double> times_s;
    for (int i = 0; i < options_.motion_samples; ++i)
        times_s.push_back(end_s - options_.exposure_time_s * (1.0 - (i + 0.5) / options_.motion_samples));
    return times_s;
}

StereoFrame mean_exposure(std::span<const StereoFrame> frames) {
    if (frames.empty()) throw std::invalid_argument("no frames to average, expected at least one");
    const StereoFrame& middle = frames[frames.size() / 2];
    StereoFrame mean = middle;
    const auto average = [&](cv::Mat EyeFrame::*plane, EyeFrame StereoFrame::*eye) {
        cv::Mat sum = cv::Mat::zeros((middle.*eye.*plane).size(), (middle.*eye.*plane).type());
        for (const StereoFrame& frame : frames) sum += frame.*eye.*plane;
        mean.*eye.*plane = sum / static_cast<double>(frames.size());
    };
    for (EyeFrame StereoFrame::*eye : {&StereoFrame::left, &StereoFrame::right}) {
        average(&EyeFrame::linear, eye);
        average(&EyeFrame::coverage, eye);
    }
    return mean;
}

}  // namespace atropos::render
