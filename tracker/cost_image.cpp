#include "tracker/cost_image.hpp"

#include <immintrin.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace atropos::tracker {
namespace {

cv::Rect grown(const cv::Rect& region, int by, int width, int height) {
    return cv::Rect(region.x - by, region.y - by, region.width + 2 * by, region.height + 2 * by) &
           cv::Rect(0, 0, width, height);
}

}  // namespace

float CostImage::at(float u, float v) const {
    // The order of the arguments makes NaN the border.
    const float x = std::min(std::max(-1.0f, u), static_cast<float>(width));
    const float y = std::min(std::max(-1.0f, v), static_cast<float>(height));
    const int ix = static_cast<int>(std::floor(x));
    const int iy = static_cast<int>(std::floor(y));
    const float tx = x - static_cast<float>(ix);
    const float ty = y - static_cast<float>(iy);
    const std::uint8_t* p = origin() + iy * stride + ix;
    const float top = static_cast<float>(p[0]) + tx * static_cast<float>(p[1] - p[0]);
    const float low = static_cast<float>(p[stride]) + tx * static_cast<float>(p[stride + 1] - p[stride]);
    return unit_px * (top + ty * (low - top));
}

CostImageMaker::CostImageMaker(const scenes::TrackerConfig& config, std::vector<double> sigmas_px,
                               int truncation_px)
    : channel_(config.thread.channel),
      threshold_(static_cast<float>(config.cost_image.threshold)),
      truncation_px_(truncation_px),
      filter_({std::move(sigmas_px), config.cost_image.blobness, config.cost_image.contrast_levels,
               config.thread.polarity}) {}

const CostImage& CostImageMaker::make(const cv::Mat& picture, const cv::Rect& region) {
    if (picture.empty() || (picture.type() != CV_8UC1 && picture.type() != CV_8UC3))
        throw std::invalid_argument(
            "an image that is neither 8-bit gray nor 8-bit BGR, expected one of them");
    cost_.width = picture.cols;
    cost_.height = picture.rows;
    // Rows keep 4 bytes to spare: a gather reads four pixels at a time.
    cost_.stride = picture.cols + 2 * CostImage::kBorder + 4;
    cost_.unit_px = static_cast<float>(truncation_px_) / 255.0f;
    cost_.values.assign(static_cast<std::size_t>(cost_.stride) *
                            static_cast<std::size_t>(picture.rows + 2 * CostImage::kBorder),
                        255);
    // Regions change from frame to frame; room for the largest means no allocation after the first.
    mask_.reserve(picture.total());
    gray_.reserve(picture.total());
    ridge_.reserve(picture.total());
    squared_.reserve(picture.total());
    transform_.reserve(picture.cols, picture.rows, truncation_px_);
    const cv::Rect inside = region & cv::Rect(0, 0, picture.cols, picture.rows);
    ridge_region_ = grown(inside, truncation_px_, picture.cols, picture.rows);
    if (inside.empty()) return cost_;
    to_gray(picture, grown(ridge_region_, filter_.reach_px(), picture.cols, picture.rows));
    filter_.apply(gray_.data(), picture.cols, picture.rows, static_cast<std::size_t>(picture.cols),
                  ridge_region_, ridge_);
    mask_.resize(ridge_.size());
    for (std::size_t i = 0; i < ridge_.size(); ++i) mask_[i] = ridge_[i] > threshold_ ? 255 : 0;
    squared_.resize(ridge_.size());
    transform_.apply(mask_.data(), ridge_region_.width, ridge_region_.width, ridge_region_.height,
                     truncation_px_, squared_.data(), ridge_region_.width);
    to_cost(inside, ridge_region_);
    return cost_;
}

void CostImageMaker::to_gray(const cv::Mat& picture, const cv::Rect& region) {
    gray_.resize(picture.total());
    for (int y = region.y; y < region.y + region.height; ++y) {
        const std::uint8_t* from = picture.ptr<std::uint8_t>(y);
        float* to = gray_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.cols);
        if (picture.channels() == 1) {
            for (int x = region.x; x < region.x + region.width; ++x) to[x] = static_cast<float>(from[x]);
            continue;
        }
        // Luma of ITU-R BT.601; or one channel of B, G, R.
        float weight[3] = {0.114f, 0.587f, 0.299f};
        if (channel_ != scenes::ImageChannel::kGray) {
            const int one = channel_ == scenes::ImageChannel::kBlue    ? 0
                            : channel_ == scenes::ImageChannel::kGreen ? 1
                                                                       : 2;
            for (int c = 0; c < 3; ++c) weight[c] = c == one ? 1.0f : 0.0f;
        }
        for (int x = region.x; x < region.x + region.width; ++x)
            to[x] = weight[0] * static_cast<float>(from[3 * x]) +
                    weight[1] * static_cast<float>(from[3 * x + 1]) +
                    weight[2] * static_cast<float>(from[3 * x + 2]);
    }
}

void CostImageMaker::to_cost(const cv::Rect& region, const cv::Rect& ridge_region) {
    const float scale = 1.0f / cost_.unit_px;
    for (int y = 0; y < region.height; ++y) {
        const std::uint16_t* from =
            squared_.data() +
            static_cast<std::ptrdiff_t>(region.y - ridge_region.y + y) * ridge_region.width +
            (region.x - ridge_region.x);
        std::uint8_t* to = cost_.values.data() +
                           static_cast<std::ptrdiff_t>(region.y + y + CostImage::kBorder) * cost_.stride +
                           region.x + CostImage::kBorder;
        int x = 0;
        for (; x + 8 <= region.width; x += 8) {
            const __m128i squares = _mm_loadu_si128(reinterpret_cast<const __m128i*>(from + x));
            const __m256 distance = _mm256_sqrt_ps(_mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(squares)));
            const __m256i steps = _mm256_cvttps_epi32(
                _mm256_add_ps(_mm256_mul_ps(distance, _mm256_set1_ps(scale)), _mm256_set1_ps(0.5f)));
            const __m128i words =
                _mm_packus_epi32(_mm256_castsi256_si128(steps), _mm256_extracti128_si256(steps, 1));
            _mm_storel_epi64(reinterpret_cast<__m128i*>(to + x), _mm_packus_epi16(words, words));
        }
        for (; x < region.width; ++x)
            to[x] = static_cast<std::uint8_t>(std::sqrt(static_cast<float>(from[x])) * scale + 0.5f);
    }
}

cv::Mat CostImageMaker::gray_picture() const {
    return cv::Mat(cost_.height, cost_.width, CV_32F, const_cast<float*>(gray_.data())).clone();
}

cv::Mat CostImageMaker::ridge_picture() const {
    cv::Mat picture = cv::Mat::zeros(cost_.height, cost_.width, CV_32F);
    if (!ridge_region_.empty())
        cv::Mat(ridge_region_.height, ridge_region_.width, CV_32F, const_cast<float*>(ridge_.data()))
            .copyTo(picture(ridge_region_));
    return picture;
}

cv::Mat CostImageMaker::mask_picture() const {
    cv::Mat picture = cv::Mat::zeros(cost_.height, cost_.width, CV_8U);
    if (!ridge_region_.empty())
        cv::Mat(ridge_region_.height, ridge_region_.width, CV_8U, const_cast<std::uint8_t*>(mask_.data()))
            .copyTo(picture(ridge_region_));
    return picture;
}

cv::Mat CostImageMaker::cost_picture() const {
    return cv::Mat(cost_.height, cost_.width, CV_8U, const_cast<std::uint8_t*>(cost_.origin()),
                   static_cast<std::size_t>(cost_.stride))
        .clone();
}

}  // namespace atropos::tracker
