#include "tracker/ground_depth.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace atropos::tracker {
namespace {

constexpr int kCoarseWidth = 320;
constexpr int kSlow = 21;       // px of a change too slow for texture
constexpr int kPatch = 35;      // px compared as one
constexpr float kLoud = 25.0f;  // levels beyond texture: gloss, edges
constexpr float kTruncation = 12.0f;
constexpr float kLeastShare = 0.3f;  // of a patch that must be ground
constexpr float kDistinct = 0.75f;   // of the mean cost, what the least must stay below
constexpr int kMostDisparities = 96;

cv::Mat1f box_mean(const cv::Mat1f& image, int size) {
    cv::Mat1f mean;
    cv::blur(image, mean, {size, size}, {-1, -1}, cv::BORDER_REPLICATE);
    return mean;
}

}  // namespace

GroundDepth::GroundDepth(const scenes::StereoRig& rig)
    : view_(rig),
      scale_(std::min(1.0, static_cast<double>(kCoarseWidth) / rig.left.width_px)),
      corner_(view_.rectified({0.0, 0.5 * rig.left.height_px}, 0).x(),
              view_.rectified({0.5 * rig.left.width_px, 0.0}, 0).y()) {
    const int width = static_cast<int>(scale_ * rig.left.width_px);
    const int height = static_cast<int>(scale_ * rig.left.height_px);
    for (std::size_t eye = 0; eye < 2; ++eye) {
        u_[eye].create(height, width);
        v_[eye].create(height, width);
        for (int j = 0; j < height; ++j)
            for (int i = 0; i < width; ++i) {
                const Eigen::Vector2d px =
                    view_.pixel(corner_ + Eigen::Vector2d(i, j) / scale_, static_cast<int>(eye));
                u_[eye](j, i) = static_cast<float>((px.x() + 0.5) * scale_ - 0.5);
                v_[eye](j, i) = static_cast<float>((px.y() + 0.5) * scale_ - 0.5);
            }
    }
}

GroundDepth::Texture GroundDepth::texture(const Eye& eye, int which) {
    bytes_.create(eye.image.height, eye.image.width);
    for (int v = 0; v < eye.image.height; ++v)
        for (int u = 0; u < eye.image.width; ++u) bytes_(v, u) = eye.image.at(u, v);
    cv::resize(bytes_, shrunk_, {}, scale_, scale_, cv::INTER_AREA);
    cv::Mat1b known(shrunk_.size(), 255);
    const auto leave_out = [&](double u, double v, int radius) {
        cv::circle(known,
                   {static_cast<int>(std::lround((u + 0.5) * scale_ - 0.5)),
                    static_cast<int>(std::lround((v + 0.5) * scale_ - 0.5))},
                   radius, 0, -1);
    };
    for (const ImagePath& line : eye.lines)
        for (std::size_t i = 0; i < line.points.size(); i += 2)
            leave_out(line.points[i].px.x(), line.points[i].px.y(), 2);
    for (int v = 0; v < eye.map.height; v += 2)
        for (int u = 0; u < eye.map.width; u += 2)
            if (eye.map.index(u, v) == RidgePointMap::kHidden) leave_out(u, v, 1);

    cv::Mat1b level, where;
    const std::size_t k = static_cast<std::size_t>(which);
    cv::remap(shrunk_, level, u_[k], v_[k], cv::INTER_LINEAR, cv::BORDER_CONSTANT);
    cv::remap(known, where, u_[k], v_[k], cv::INTER_NEAREST, cv::BORDER_CONSTANT);
    Texture texture;
    level.convertTo(texture.level, CV_32F);
    where.convertTo(texture.known, CV_32F, 1.0 / 255.0);
    cv::Mat1f mean;
    cv::multiply(texture.level, texture.known, mean);
    cv::divide(box_mean(mean, kSlow), box_mean(texture.known, kSlow) + cv::Scalar(1e-3), mean);
    texture.level -= mean;
    texture.known.setTo(0.0f, cv::abs(texture.level) > kLoud);
    texture.level.setTo(0.0f, texture.known < 0.5f);
    return texture;
}

void GroundDepth::look(const Eye& left, const Eye& right, double farthest_m, double largest_px) {
    const Texture l = texture(left, 0), r = texture(right, 1);
    const cv::Size size = l.level.size();
    const int first = std::max(0, static_cast<int>(view_.disparity_px(farthest_m) * scale_));
    const int count = std::clamp(static_cast<int>(std::ceil(largest_px * scale_)) + 2 - first, 3,
                                 std::min(kMostDisparities, size.width - first - 1));
    std::vector<cv::Mat1f> costs;
    cv::Mat1f least(size, 1e9f), sum(size, 0.0f), patches(size, 0.0f);
    cv::Mat1b best(size, 0);
    for (int k = 0; k < count; ++k) {
        cv::Mat1f cost(size, 0.0f), both(size, 0.0f);
        for (int v = 0; v < size.height; ++v)
            for (int u = first + k; u < size.width; ++u) {
                const int w = u - first - k;
                both(v, u) = l.known(v, u) * r.known(v, w);
                cost(v, u) = both(v, u) * std::min(std::abs(l.level(v, u) - r.level(v, w)), kTruncation);
            }
        const cv::Mat1f share = box_mean(both, kPatch);
        cv::divide(box_mean(cost, kPatch), share + cv::Scalar(1e-6), cost);
        for (int v = 0; v < size.height; ++v)
            for (int u = 0; u < size.width; ++u) {
                if (share(v, u) < kLeastShare) {
                    cost(v, u) = -1.0f;
                    continue;
                }
                sum(v, u) += cost(v, u);
                patches(v, u) += 1.0f;
                if (cost(v, u) >= least(v, u)) continue;
                least(v, u) = cost(v, u);
                best(v, u) = static_cast<unsigned char>(k);
            }
        costs.push_back(cost);
    }
    disparity_px_.create(size);
    for (int v = 0; v < size.height; ++v)
        for (int u = 0; u < size.width; ++u) {
            disparity_px_(v, u) = -1.0f;
            const int k = best(v, u);
            if (patches(v, u) < 3.0f || k < 1 || k + 1 >= count) continue;
            if (least(v, u) > kDistinct * sum(v, u) / patches(v, u)) continue;
            const float before = costs[static_cast<std::size_t>(k - 1)](v, u);
            const float after = costs[static_cast<std::size_t>(k + 1)](v, u);
            if (before < 0.0f || after < 0.0f) continue;
            const float bend = before - 2.0f * least(v, u) + after;
            const float shift = bend > 1e-6f ? 0.5f * (before - after) / bend : 0.0f;
            disparity_px_(v, u) = (static_cast<float>(first + k) + shift) / static_cast<float>(scale_);
        }
}

std::optional<double> GroundDepth::disparity_px(const Eigen::Vector2d& left) const {
    const Eigen::Vector2d p = scale_ * (left - corner_);
    const int u = static_cast<int>(std::lround(p.x())), v = static_cast<int>(std::lround(p.y()));
    if (u < 0 || v < 0 || u >= disparity_px_.cols || v >= disparity_px_.rows) return std::nullopt;
    const float d = disparity_px_(v, u);
    return d < 0.0f ? std::nullopt : std::optional<double>(static_cast<double>(d));
}

}  // namespace atropos::tracker
