#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <string>

#include "scenes/polyline.hpp"
#include "scenes/stereo_rig.hpp"
#include "scenes/thread_estimate.hpp"

namespace atropos::experiments {

/// What is drawn over a stereo pair.
struct Overlay {
    const scenes::ThreadEstimate* estimate = nullptr;
    std::span<const Eigen::Vector3d> control_points;  ///< in C
    const scenes::Polyline* truth_C = nullptr;        ///< thin, when there is one
    std::string caption;
};

/// The left picture in colour, enlarged `zoom` times, with the reprojected spline, its control points and the
/// marked middle (the paper's fig. 5a).
cv::Mat draw_overlay(const cv::Mat& picture, const scenes::StereoRig& rig, int eye, const Overlay& overlay,
                     int zoom = 1);

/// Both eyes side by side.
cv::Mat draw_stereo_overlay(const cv::Mat& left, const cv::Mat& right, const scenes::StereoRig& rig,
                            const Overlay& overlay, int zoom = 1);

}  // namespace atropos::experiments
