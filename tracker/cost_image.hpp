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
/// clamped to the border needs no other check. Each pixel is kept with the one below it: 32 bits from there
/// hold the four values between which a look-up interpolates.
struct CostImage {
    static constexpr int kBorder = 2;
    static constexpr std::uint16_t kFar = 0xffff;

    int width = 0;  ///< of the image it belongs to
    int height = 0;
    int stride = 0;  ///< of `pairs`, border included
    float unit_px = 1.0f;
    std::vector<std::uint16_t> pairs;  ///< low byte: value of the pixel; high byte: of the one below

    std::uint16_t* row(int y) { return pairs.data() + (kBorder + y) * stride + kBorder; }
    const std::uint16_t* row(int y) const { return pairs.data() + (kBorder + y) * stride + kBorder; }

    /// Cost at a pixel, bilinear between pixel centres, px; the truncation outside.
    float at(float u, float v) const;
};

/// Makes a cost image: detector, threshold, truncated distance transform. Works in square tiles, only where
/// it is asked for, so that the cost follows the thread's length and not the image's size. Keeps its buffers
/// from frame to frame.
class CostImageMaker {
  public:
    /// `sigmas_px`: scales of the detector; `truncation_px` in pixels of this image.
    CostImageMaker(const scenes::TrackerConfig& config, std::vector<double> sigmas_px, int truncation_px);

    /// A new frame, 8 bit gray or BGR, of which nothing is known yet; it must live until the next one. Throws
    /// std::invalid_argument for other types of image.
    void begin(const cv::Mat& picture);

    /// Another truncation for the same frame: ridges that were detected stay, costs are made anew.
    void set_truncation(int truncation_px);

    /// Asks for the cost at these pixels and those next to them; the part outside the image is left out.
    void want(const cv::Rect& region);

    /// Computes what has been asked for. In those tiles the bytes are those of the whole picture; elsewhere
    /// the cost is the truncation.
    void compute();

    /// All three for one region.
    const CostImage& make(const cv::Mat& picture, const cv::Rect& region);

    const CostImage& cost() const { return cost_; }
    int truncation_px() const { return truncation_px_; }

    /// The steps for the whole frame, for figures: gray and ridge as float, mask and cost as 8 bit.
    struct Pictures {
        cv::Mat gray, ridge, mask, cost;
    };
    Pictures pictures() const;

  private:
    struct Run {
        int row, first, last;  ///< tiles [first, last) of one row of tiles
    };
    template <typename IsIn, typename Task>
    void for_each_run(IsIn&& is_in, Task&& task) const;
    void make_room(const cv::Size& size);
    void forget_costs();
    cv::Rect pixels(const Run& run) const;
    cv::Rect tiles_of(const cv::Rect& region) const;
    void detect(const cv::Rect& region);
    void to_gray(const cv::Rect& region);
    void to_distance(const cv::Rect& region);
    void to_cost(const cv::Rect& region);

    scenes::ImageChannel channel_;
    float threshold_;
    int truncation_px_;
    RidgeFilter filter_;
    DistanceTransform transform_;
    cv::Mat picture_;
    int tiles_x_ = 0, tiles_y_ = 0;
    std::vector<std::uint8_t> cost_wanted_, cost_done_;  ///< one a tile
    std::vector<std::uint8_t> mask_wanted_, mask_done_;
    std::vector<float> gray_;             ///< whole image, filled where needed
    std::vector<std::uint8_t> mask_;      ///< whole image, filled where needed
    std::vector<float> ridge_;            ///< of one run
    std::vector<std::uint16_t> squared_;  ///< of one run
    std::vector<std::uint8_t> values_;    ///< costs of one run
    CostImage cost_;
};

}  // namespace atropos::tracker
