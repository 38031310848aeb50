#include "experiments/rectifier.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace atropos::experiments {
using Eigen::Vector2d;
using Eigen::Vector3d;
namespace {

constexpr float kOcclusion_px =
    1.0f;  ///< disagreement of both disparities from which a point counts as hidden

/// 255 where the other eye's disparity at the corresponding pixel is larger: something stands before the
/// point.
cv::Mat1b occlusion(const cv::Mat1f& mine, const cv::Mat1f& other, int sign) {
    cv::Mat1b hidden(mine.size(), 0);
    for (int v = 0; v < mine.rows; ++v)
        for (int u = 0; u < mine.cols; ++u) {
            const float d = mine(v, u);
            if (d <= 0.0f) continue;
            const int there = u - sign * static_cast<int>(std::lround(d));
            const bool outside = there < 0 || there >= other.cols;
            if (outside || other(v, there) > d + kOcclusion_px) hidden(v, u) = 255;
        }
    return hidden;
}

}  // namespace

Rectifier::Rectifier(const scenes::StereoRig& rig) {
    const scenes::Rectification r = rig.rectification();
    left_ = eye(rig.left, r.R1, r.P1);
    right_ = eye(rig.right, r.R2, r.P2);
    focal_baseline_ = -r.P2(0, 3);
}

Rectifier::Eye Rectifier::eye(const scenes::Camera& camera, const Eigen::Matrix3d& rotation,
                              const scenes::ProjectionMatrix& P) {
    Eye eye{cv::Mat2f(camera.height_px, camera.width_px), cv::Mat1f(camera.height_px, camera.width_px)};
    const Eigen::Matrix3d unproject = P.leftCols<3>().inverse();
    for (int v = 0; v < camera.height_px; ++v)
        for (int u = 0; u < camera.width_px; ++u) {
            const Vector3d ray = unproject * Vector3d(u, v, 1.0), p = rotation.transpose() * ray;
            const Vector2d source = camera.project(p);
            eye.source(v, u) = cv::Vec2f(static_cast<float>(source.x()), static_cast<float>(source.y()));
            eye.z_ratio(v, u) = static_cast<float>(ray.z() / p.z());
        }
    return eye;
}

cv::Mat1f Rectifier::disparity(const Eye& eye, const cv::Mat& depth_m) const {
    cv::Mat1f z;
    cv::remap(depth_m, z, eye.source, cv::noArray(), cv::INTER_NEAREST, cv::BORDER_CONSTANT, cv::Scalar(0));
    cv::Mat1f d(z.size(), 0.0f);
    for (int v = 0; v < z.rows; ++v)
        for (int u = 0; u < z.cols; ++u)
            if (z(v, u) > 0.0f) d(v, u) = static_cast<float>(focal_baseline_) / (z(v, u) * eye.z_ratio(v, u));
    return d;
}

RectifiedPair Rectifier::rectify(const cv::Mat& left, const cv::Mat& right, const cv::Mat& depth_left_m,
                                 const cv::Mat& depth_right_m) const {
    RectifiedPair pair;
    cv::remap(left, pair.left, left_.source, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_CONSTANT,
              cv::Scalar());
    cv::remap(right, pair.right, right_.source, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_CONSTANT,
              cv::Scalar());
    pair.disparity_left = disparity(left_, depth_left_m);
    pair.disparity_right = disparity(right_, depth_right_m);
    pair.occlusion_left = occlusion(pair.disparity_left, pair.disparity_right, 1);
    pair.occlusion_right = occlusion(pair.disparity_right, pair.disparity_left, -1);
    return pair;
}

}  // namespace atropos::experiments
