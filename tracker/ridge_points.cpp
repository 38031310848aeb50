#include "tracker/ridge_points.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace atropos::tracker {
namespace {

/// The ridge point of a pixel from the smoothed image around it; false when the extremum lies in another.
/// `sign` is 1 for dark lines, -1 for bright ones.
bool ridge_point(const cv::Mat1f& smooth, int u, int v, float sign, float least, RidgePoint& point,
                 float& curvature) {
    const float* above = smooth[v - 1] + u;
    const float* here = smooth[v] + u;
    const float* below = smooth[v + 1] + u;
    const float xx = sign * (here[-1] - 2.0f * here[0] + here[1]);
    const float yy = sign * (above[0] - 2.0f * here[0] + below[0]);
    if (xx + yy < 0.5f * least) return false;
    const float xy = 0.25f * sign * (above[-1] - above[1] - below[-1] + below[1]);
    const float half = 0.5f * (xx - yy);
    const float root = std::sqrt(half * half + xy * xy);
    curvature = 0.5f * (xx + yy) + root;
    if (curvature < least) return false;
    Eigen::Vector2f normal =
        half >= 0.0f ? Eigen::Vector2f(half + root, xy) : Eigen::Vector2f(xy, root - half);
    const float size = normal.norm();
    if (size < 1e-12f) return false;
    normal /= size;
    const float x = 0.5f * sign * (here[1] - here[-1]);
    const float y = 0.5f * sign * (below[0] - above[0]);
    const Eigen::Vector2f offset = -(x * normal.x() + y * normal.y()) / curvature * normal;
    constexpr float kWithin = 0.6f;  // a little beyond the pixel, or noise tears lines at its border
    if (std::abs(offset.x()) > kWithin || std::abs(offset.y()) > kWithin) return false;
    point.px = Eigen::Vector2d(u, v) + offset.cast<double>();
    point.tangent = {-static_cast<double>(normal.y()), static_cast<double>(normal.x())};
    return true;
}

}  // namespace

// A spot of gloss has a dark rim once smoothed, which would lead lines around it: it gets the ground's level.
void RidgePointDetector::level_gloss() {
    constexpr int kCoarse = 4;  // the ground changes slowly
    cv::resize(source_, coarse_, {}, 1.0 / kCoarse, 1.0 / kCoarse, cv::INTER_AREA);
    coarse_.convertTo(coarse_bytes_, CV_8U);
    cv::medianBlur(coarse_bytes_, coarse_bytes_, 7);
    cv::resize(coarse_bytes_, ground_bytes_, source_.size(), 0.0, 0.0, cv::INTER_LINEAR);
    ground_bytes_.convertTo(ground_, CV_32F);
    gloss_ = source_ > ground_ + options_.gloss_levels;
    cv::dilate(gloss_, gloss_, cv::Mat1b::ones(3, 3));
    ground_.copyTo(source_, gloss_);
}

void RidgePointDetector::detect(const ImageView& image, RidgePointMap& map) {
    map.width = image.width;
    map.height = image.height;
    map.points.clear();
    map.at_pixel.assign(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height), -1);
    source_.create(image.height, image.width);
    for (int v = 0; v < image.height; ++v)
        for (int u = 0; u < image.width; ++u) source_[v][u] = image.at(u, v);
    const bool dark = options_.polarity != scenes::ThreadPolarity::kBright;
    const bool bright = options_.polarity != scenes::ThreadPolarity::kDark;
    if (!bright) level_gloss();
    const double sigma = options_.sigma_px;
    const int reach = static_cast<int>(std::ceil(3.5 * sigma));
    cv::GaussianBlur(source_, smooth_, {2 * reach + 1, 2 * reach + 1}, sigma, sigma, cv::BORDER_REPLICATE);

    const float least = static_cast<float>(options_.low_levels / (sigma * sigma));
    for (int v = 1; v + 1 < image.height; ++v)
        for (int u = 1; u + 1 < image.width; ++u) {
            RidgePoint point;
            float curvature = 0.0f;
            if (!(dark && ridge_point(smooth_, u, v, 1.0f, least, point, curvature)) &&
                !(bright && ridge_point(smooth_, u, v, -1.0f, least, point, curvature)))
                continue;
            point.strength_levels = sigma * sigma * static_cast<double>(curvature);
            map.at_pixel[static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width) +
                         static_cast<std::size_t>(u)] = static_cast<std::int32_t>(map.points.size());
            map.points.push_back(point);
        }
}

}  // namespace atropos::tracker
