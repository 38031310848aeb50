#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "scenes/tracker_config.hpp"
#include "tracker/distance_transform.hpp"
#include "tracker/ridge_filter.hpp"

namespace atropos::tracker {

/// The cost image I_i of one eye (II-E): low on the thread. Values are truncated distances to the nearest
/// ridge in steps of `unit_px`, with a border of `kBorder` pixels at the truncation, so that a look-up
/// clamped to the border needs no other check.
struct CostImage {
    static constexpr int kBorder = 2;

    int width = 0;  ///< of the image it belongs to
    int height = 0;
    int stride = 0;  ///< of `values`, border included
    float unit_px = 1.0f;
    std::vector<std::uint8_t> values;

    const std::uint8_t* origin() const { return values.data() + kBorder * stride + kBorder; }

    /// Cost at a pixel, bilinear between pixel centres, px; the truncation outside.
    float at(float u, float v) const;
};

/// Makes a cost image: detector, threshold, truncated distance transform. Keeps every step's result for
/// figures, and its buffers from frame to frame.
class CostImageMaker {
  public:
    /// `sigmas_px`: scales of the detector; `truncation_px` in pixels of this image.
    CostImageMaker(const scenes::TrackerConfig& config, std::vector<double> sigmas_px, int truncation_px);

    /// `picture`: 8 bit gray or BGR. Inside `region` the bytes are those of the whole picture; outside the
    /// cost is the truncation. Throws std::invalid_argument for other types of image.
    const CostImage& make(const cv::Mat& picture, const cv::Rect& region);

    const CostImage& cost() const { return cost_; }
    int truncation_px() const { return truncation_px_; }

    /// The last call's steps as pictures of the whole image: gray and ridge as float, mask and cost as 8 bit.
    cv::Mat gray_picture() const;
    cv::Mat ridge_picture() const;
    cv::Mat mask_picture() const;
    cv::Mat cost_picture() const;

  private:
    void to_gray(const cv::Mat& picture, const cv::Rect& region);
    void to_cost(const cv::Rect& region, const cv::Rect& ridge_region);

    scenes::ImageChannel channel_;
    float threshold_;
    int truncation_px_;
    RidgeFilter filter_;
    DistanceTransform transform_;
    cv::Rect ridge_region_;
    std::vector<float> gray_;             ///< whole image, filled where needed
    std::vector<float> ridge_;            ///< of ridge_region_
    std::vector<std::uint8_t> mask_;      ///< of ridge_region_
    std::vector<std::uint16_t> squared_;  ///< of ridge_region_
    CostImage cost_;
};

}  // namespace atropos::tracker
