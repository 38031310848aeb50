#include "experiments/degradation.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

namespace atropos::experiments {
namespace {

constexpr double kBarPeriod_s = 1.0;

void add_noise(cv::Mat& picture, double levels, std::uint64_t seed) {
    scenes::RandomStream stream(seed, "degradation.noise");
    for (int v = 0; v < picture.rows; ++v) {
        auto* row = picture.ptr<unsigned char>(v);
        for (int i = 0; i < picture.cols * picture.channels(); ++i)
            row[i] = cv::saturate_cast<unsigned char>(row[i] + levels * stream.normal());
    }
}

void lose_contrast(cv::Mat& picture, double loss) {
    const cv::Scalar mean = cv::mean(picture);
    cv::Mat flat(picture.size(), picture.type(), mean);
    cv::addWeighted(picture, 1.0 - loss, flat, loss, 0.0, picture);
}

/// A bar of the picture's mean colour that goes from the left edge to the right one in a second.
void occlude(cv::Mat& picture, double width_px, double time_s) {
    const double phase = time_s / kBarPeriod_s - std::floor(time_s / kBarPeriod_s);
    const int begin = static_cast<int>(std::lround((picture.cols + width_px) * phase - width_px));
    const cv::Rect bar(begin, 0, static_cast<int>(std::lround(width_px)), picture.rows);
    const cv::Rect seen = bar & cv::Rect(0, 0, picture.cols, picture.rows);
    if (seen.area() > 0) picture(seen).setTo(cv::mean(picture));
}

void degrade_picture(cv::Mat& picture, const Degradation& d, double time_s, std::uint64_t seed) {
    picture = picture.clone();
    if (d.occlusion_px > 0.0) occlude(picture, d.occlusion_px, time_s);
    if (d.blur_px > 0.0) cv::GaussianBlur(picture, picture, {}, d.blur_px);
    if (d.contrast_loss > 0.0) lose_contrast(picture, d.contrast_loss);
    if (d.noise_levels > 0.0) add_noise(picture, d.noise_levels, seed);
}

}  // namespace

double* degradation_field(Degradation& d, std::string_view field) {
    const std::array<std::pair<std::string_view, double*>, 6> fields{
        {{"noise_levels", &d.noise_levels},
         {"blur_px", &d.blur_px},
         {"contrast_loss", &d.contrast_loss},
         {"tip_error_mm", &d.tip_error_mm},
         {"calibration_error_deg", &d.calibration_error_deg},
         {"occlusion_px", &d.occlusion_px}}};
    for (const auto& [name, value] : fields)
        if (name == field) return value;
    return nullptr;
}

bool Degradation::any() const {
    return noise_levels > 0.0 || blur_px > 0.0 || contrast_loss > 0.0 || tip_error_mm > 0.0 ||
           calibration_error_deg != 0.0 || occlusion_px > 0.0;
}

scenes::StereoRig degraded(const scenes::StereoRig& rig, const Degradation& d) {
    scenes::StereoRig wrong = rig;
    wrong.X_RC.linear() =
        Eigen::AngleAxisd(d.calibration_error_deg * std::numbers::pi / 180.0, Eigen::Vector3d::UnitY()) *
        rig.X_RC.linear();
    return wrong;
}

void degrade(tracker::StereoFrame& frame, const Degradation& d, std::uint64_t seed) {
    if (!d.any()) return;
    const std::uint64_t of_frame = scenes::derive_seed(seed, static_cast<std::uint64_t>(frame.index));
    degrade_picture(frame.left, d, frame.capture_time_s, scenes::derive_seed(of_frame, 0));
    degrade_picture(frame.right, d, frame.capture_time_s, scenes::derive_seed(of_frame, 1));
    scenes::RandomStream offsets(seed,
                                 "degradation.tips");  // the same in all frames, as a registration error is
    for (auto& tip : frame.tips)
        for (int i = 0; i < 3; ++i) {
            const double offset_m = 1e-3 * d.tip_error_mm * offsets.normal();
            if (tip) tip->p_C[i] += offset_m;
        }
}

}  // namespace atropos::experiments
