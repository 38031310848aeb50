#include <cmath>
#include <stdexcept>
#include <string>

#include "tracker/distance_transform.hpp"
#include "tracker/refined_tracker.hpp"
#include "tracker/stereo_tracker.hpp"
#include "tracker/thread_tracker.hpp"

namespace atropos::tracker {
namespace {

void require(bool holds, const std::string& what) {
    if (!holds) throw std::invalid_argument(what);
}

void require_range(const char* key, double value, double low, double high) {
    require(value >= low && value <= high, std::string(key) + " is " + std::to_string(value) + ", expected " +
                                               std::to_string(low) + " to " + std::to_string(high));
}

// Says nothing, and allocates nothing, when all is well: it runs on every frame.
void check_image(const char* name, const cv::Mat& image, const scenes::Camera& camera) {
    const auto refuse = [name](const std::string& what) {
        throw std::invalid_argument(std::string("the ") + name + " image " + what);
    };
    if (image.empty()) refuse("is missing, expected one");
    if (image.type() != CV_8UC1 && image.type() != CV_8UC3) refuse("is neither 8-bit gray nor 8-bit BGR");
    if (image.cols != camera.width_px || image.rows != camera.height_px)
        refuse("is " + std::to_string(image.cols) + "x" + std::to_string(image.rows) +
               ", expected the camera's " + std::to_string(camera.width_px) + "x" +
               std::to_string(camera.height_px));
}

}  // namespace

void check_frame(const StereoFrame& frame, const scenes::StereoRig& rig) {
    check_image("left", frame.left, rig.left);
    check_image("right", frame.right, rig.right);
    for (std::size_t end = 0; end < 2; ++end) {
        if (!frame.tips[end]) continue;
        const Eigen::Vector3d& p_C = frame.tips[end]->p_C;
        if (!p_C.allFinite())
            throw std::invalid_argument("the measured end " + std::to_string(end) +
                                        " is not a number, expected a position in metres");
        if (p_C.z() <= 0.0 || (rig.X_RC * p_C).z() <= 0.0)
            throw std::invalid_argument("the measured end " + std::to_string(end) +
                                        " lies behind a camera, expected before both");
    }
}

void validate(const scenes::TrackerConfig& config) {
    require_range("threads", config.threads, 1, 256);
    require_range("K", config.curve.control_points, config.curve.degree + 1, 64);
    require_range("degree", config.curve.degree, 1, 5);
    require_range("samples", config.curve.samples, config.curve.control_points, 1000);
    require_range("thread.length_m", config.thread.length_m, 0.0, 10.0);
    require(!config.thread.length_is_known || config.thread.length_m > 0.0,
            "thread.length_m is 0 though it is said to be known, expected more");
    require_range("thread.width_m", config.thread.width_m, 1e-6, 0.1);
    require_range("labels.r", config.labels.r, 1, 8);
    require_range("labels.s_m", config.labels.s_m, 1e-7, 0.1);
    require_range("labels.steps", config.labels.steps, 1, 6);
    require_range("labels.depth_factor", config.labels.depth_factor, 0.01, 100.0);
    require_range("cost_image.scales", config.cost_image.scales, 1, 8);
    require_range("cost_image.scale_step", config.cost_image.scale_step, 1.01, 4.0);
    require_range("cost_image.blobness", config.cost_image.blobness, 0.01, 100.0);
    require_range("cost_image.contrast_levels", config.cost_image.contrast_levels, 0.01, 1000.0);
    require_range("cost_image.threshold", config.cost_image.threshold, 0.0, 1.0);
    require_range("cost_image.truncation_px", config.cost_image.truncation_px, 1.0,
                  DistanceTransform::kMaxTruncation);
    require_range("lambda1_e1", config.lambda1_e1, 0.0, 1e9);
    require_range("lambda2_e1_per_m", config.lambda2_e1_per_m, 0.0, 1e9);
    require_range("lambda1_e2", config.lambda1_e2, 0.0, 1e9);
    require_range("tips.epsilon_m", config.tips.epsilon_m, 0.0, 1.0);
    require_range("tips.weight_per_m", config.tips.weight_per_m, 0.0, 1e12);
    require_range("lambda_stereo", config.lambda_stereo, 0.0, 1e9);
    require_range("uncertainty.lateral_px", config.uncertainty.lateral_px, 0.0, 1000.0);
    require_range("uncertainty.disparity_px", config.uncertainty.disparity_px, 0.0, 1000.0);
    const int K = config.refined.control_points == 0 ? 16 : config.refined.control_points;
    require_range("refined.control_points", K, 4, 64);
    require_range("refined.samples", config.refined.samples, 2 * K, 1000);
    require_range("refined.search_px", config.refined.search_px, 4.0, 40.0);
    require_range("refined.contrast_levels", config.refined.contrast_levels, 0.5, 255.0);
    require_range("refined.blur_px", config.refined.blur_px, 0.1, 10.0);
    require_range("refined.length_sigma_m", config.refined.length_sigma_m, 1e-6, 1.0);
    require_range("refined.tip_sigma_m", config.refined.tip_sigma_m, 1e-6, 1.0);
    require_range("refined.tip_bias_sigma_m", config.refined.tip_bias_sigma_m, 0.0, 1.0);
    require_range("refined.instrument_sigma_m", config.refined.instrument_sigma_m, 0.0, 0.1);
    require_range("refined.prior_weight", config.refined.prior_weight, 0.0, 1000.0);
    require(config.refined.gravity_C.allFinite(), "refined.gravity_C is not a number, expected a direction");
    require_range("refined.coasting_frames", config.refined.coasting_frames, 0, 100000);
}

std::unique_ptr<StereoTracker> make_tracker(const scenes::TrackerConfig& config, const scenes::StereoRig& rig,
                                            const DeformationPrior* prior) {
    validate(config);
    if (config.method == scenes::TrackerMethod::kRefined) {
        require(prior || config.refined.prior_file.empty(),
                "refined.prior_file is named and nothing of it given, expected what was learned");
        return std::make_unique<RefinedTracker>(config, rig, CurvePriors{},
                                                prior ? std::make_optional(*prior) : std::nullopt);
    }
    return std::make_unique<ThreadTracker>(config, rig);
}

}  // namespace atropos::tracker
