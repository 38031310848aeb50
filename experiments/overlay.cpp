#include "experiments/overlay.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace atropos::experiments {
namespace {

constexpr int kShift = 4;  // sub-pixel bits of OpenCV's drawing
const cv::Scalar kCurve(60, 220, 60), kTruth(255, 160, 0), kControl(0, 200, 255), kMiddle(60, 60, 255);

struct Canvas {
    cv::Mat picture;
    const scenes::StereoRig& rig;
    int eye;
    int zoom;

    cv::Point point(const Eigen::Vector3d& p_C) const {
        const Eigen::Vector2d px = eye == 0 ? rig.project_left(p_C) : rig.project_right(p_C);
        const auto fixed = [this](double x) {
            return static_cast<int>(
                std::lround(std::clamp(((x + 0.5) * zoom - 0.5), -1e4, 1e5) * (1 << kShift)));
        };
        return {fixed(px.x()), fixed(px.y())};
    }
    void line(std::span<const Eigen::Vector3d> points, const cv::Scalar& colour) {
        for (size_t i = 1; i < points.size(); ++i)
            cv::line(picture, point(points[i - 1]), point(points[i]), colour, 1, cv::LINE_AA, kShift);
    }
    void circle(const Eigen::Vector3d& p_C, int radius_px, const cv::Scalar& colour, int thickness) {
        cv::circle(picture, point(p_C), radius_px << kShift, colour, thickness, cv::LINE_AA, kShift);
    }
};

}  // namespace

cv::Mat draw_overlay(const cv::Mat& picture, const scenes::StereoRig& rig, int eye, const Overlay& overlay,
                     int zoom) {
    Canvas canvas{{}, rig, eye, zoom};
    if (picture.channels() == 1)
        cv::cvtColor(picture, canvas.picture, cv::COLOR_GRAY2BGR);
    else
        canvas.picture = picture.clone();
    if (zoom > 1) cv::resize(canvas.picture, canvas.picture, {}, zoom, zoom, cv::INTER_CUBIC);
    if (overlay.truth_C) canvas.line(overlay.truth_C->points, kTruth);
    if (overlay.estimate && !overlay.estimate->samples.empty()) {
        std::vector<Eigen::Vector3d> curve;
        for (const auto& sample : overlay.estimate->samples) curve.push_back(sample.p_C);
        canvas.line(curve, kCurve);
        for (const auto& p : overlay.control_points) canvas.circle(p, 2, kControl, 1);
        canvas.circle(curve[curve.size() / 2], 5, kMiddle, 1);
    }
    if (!overlay.caption.empty()) {
        const cv::Point at(8, 16);
        cv::putText(canvas.picture, overlay.caption, at, cv::FONT_HERSHEY_SIMPLEX, 0.42, {0, 0, 0}, 3,
                    cv::LINE_AA);
        cv::putText(canvas.picture, overlay.caption, at, cv::FONT_HERSHEY_SIMPLEX, 0.42, {255, 255, 255}, 1,
                    cv::LINE_AA);
    }
    return canvas.picture;
}

cv::Mat draw_stereo_overlay(const cv::Mat& left, const cv::Mat& right, const scenes::StereoRig& rig,
                            const Overlay& overlay, int zoom) {
    cv::Mat both;
    cv::hconcat(draw_overlay(left, rig, 0, overlay, zoom), draw_overlay(right, rig, 1, overlay, zoom), both);
    return both;
}

}  // namespace atropos::experiments
