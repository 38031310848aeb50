#pragma once

#include <opencv2/core.hpp>

#include "scenes/stereo_rig.hpp"

namespace atropos::experiments {

/// What a rectified pair adds to a sequence. Disparities are of all surfaces but the thread, as the depth is.
struct RectifiedPair {
    cv::Mat left, right;                        ///< as the pictures, rows agree
    cv::Mat1f disparity_left, disparity_right;  ///< px, u_left - u_right; 0 = nothing there
    cv::Mat1b occlusion_left, occlusion_right;  ///< 255 where the other eye doesn't see the point
};

/// Warps pictures and depth of a rig to its rectified geometry (calib/stereo.yaml: R1 R2 P1 P2), same size.
class Rectifier {
  public:
    explicit Rectifier(const scenes::StereoRig& rig);

    /// `depth_left_m`, `depth_right_m`: z in C and in R of each pixel as the cameras see it, 0 = nothing.
    RectifiedPair rectify(const cv::Mat& left, const cv::Mat& right, const cv::Mat& depth_left_m,
                          const cv::Mat& depth_right_m) const;

  private:
    struct Eye {
        cv::Mat2f source;   ///< pixel of the original picture for each rectified one
        cv::Mat1f z_ratio;  ///< z in the rectified frame over z in the camera's frame along the pixel's ray
    };
    static Eye eye(const scenes::Camera& camera, const Eigen::Matrix3d& rotation,
                   const scenes::ProjectionMatrix& P);
    cv::Mat1f disparity(const Eye& eye, const cv::Mat& depth_m) const;

    Eye left_, right_;
    double focal_baseline_ = 0.0;  ///< px m
};

}  // namespace atropos::experiments
