#include "tracker/stereo_cost_images.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace atropos::tracker {

StereoCostImages::StereoCostImages(const scenes::TrackerConfig& config, std::vector<double> sigmas_px,
                                   int truncation_px)
    : makers_{CostImageMaker(config, sigmas_px, truncation_px),
              CostImageMaker(config, sigmas_px, truncation_px)} {}

void StereoCostImages::make(const StereoFrame& frame, const std::array<cv::Rect, 2>& regions,
                            WorkerPool& pool) {
    pool.run(2, [&](int eye) {
        makers_[static_cast<std::size_t>(eye)].make(eye == 0 ? frame.left : frame.right,
                                                    regions[static_cast<std::size_t>(eye)]);
    });
}

void StereoCostImages::show(TrackObserver& observer) const {
    for (int eye = 0; eye < 2; ++eye) {
        const CostImageMaker& maker = makers_[static_cast<std::size_t>(eye)];
        observer.image("gray", eye, maker.gray_picture());
        observer.image("ridge", eye, maker.ridge_picture());
        observer.image("mask", eye, maker.mask_picture());
        observer.image("cost", eye, maker.cost_picture());
    }
}

cv::Rect region_around(const Eye& eye, std::span<const Eigen::Vector3d> points_C, double margin_px,
                       const cv::Size& image) {
    Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
    Eigen::Vector2d high = -low;
    for (const Eigen::Vector3d& p_C : points_C) {
        const Eigen::Vector2d pixel = eye.pixel(eye.homogeneous(p_C));
        low = low.cwiseMin(pixel);
        high = high.cwiseMax(pixel);
    }
    const auto clipped = [](double value, int size) {
        return static_cast<int>(std::floor(std::clamp(value, 0.0, static_cast<double>(size))));
    };
    const int x0 = clipped(low.x() - margin_px, image.width);
    const int y0 = clipped(low.y() - margin_px, image.height);
    const int x1 = clipped(high.x() + margin_px + 1.0, image.width);
    const int y1 = clipped(high.y() + margin_px + 1.0, image.height);
    return {x0, y0, x1 - x0, y1 - y0};
}

}  // namespace atropos::tracker
