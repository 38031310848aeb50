#include "tracker/cost_image.hpp"

#include <immintrin.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace atropos::tracker {
namespace {

constexpr int kTile_px = 32;

cv::Rect grown(const cv::Rect& region, int by, int width, int height) {
    return cv::Rect(region.x - by, region.y - by, region.width + 2 * by, region.height + 2 * by) &
           cv::Rect(0, 0, width, height);
}

/// Square roots times `scale`, rounded.
void to_steps(const std::vector<std::uint16_t>& squared, float scale, std::vector<std::uint8_t>& steps) {
    std::size_t i = 0;
    for (; i + 8 <= squared.size(); i += 8) {
        const __m128i squares = _mm_loadu_si128(reinterpret_cast<const __m128i*>(squared.data() + i));
        const __m256 distance = _mm256_sqrt_ps(_mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(squares)));
        const __m256i rounded = _mm256_cvttps_epi32(
            _mm256_add_ps(_mm256_mul_ps(distance, _mm256_set1_ps(scale)), _mm256_set1_ps(0.5f)));
        const __m128i words =
            _mm_packus_epi32(_mm256_castsi256_si128(rounded), _mm256_extracti128_si256(rounded, 1));
        _mm_storel_epi64(reinterpret_cast<__m128i*>(steps.data() + i), _mm_packus_epi16(words, words));
    }
    for (; i < squared.size(); ++i)
        steps[i] = static_cast<std::uint8_t>(std::sqrt(static_cast<float>(squared[i])) * scale + 0.5f);
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
    const std::uint16_t* p = row(iy) + ix;
    const int here = p[0] & 255, below = p[0] >> 8, right = p[1] & 255, across = p[1] >> 8;
    const float top = static_cast<float>(here) + tx * static_cast<float>(right - here);
    const float low = static_cast<float>(below) + tx * static_cast<float>(across - below);
    return unit_px * (top + ty * (low - top));
}

CostImageMaker::CostImageMaker(const scenes::TrackerConfig& config, std::vector<double> sigmas_px,
                               int truncation_px)
    : channel_(config.thread.channel),
      threshold_(static_cast<float>(config.cost_image.threshold)),
      truncation_px_(truncation_px),
      filter_({std::move(sigmas_px), config.cost_image.blobness, config.cost_image.contrast_levels,
               config.thread.polarity, config.cost_image.threshold}) {}

// All room at once: which tiles are needed changes from frame to frame, and no frame may allocate.
void CostImageMaker::make_room(const cv::Size& size) {
    cost_.width = size.width;
    cost_.height = size.height;
    cost_.stride = size.width + 2 * CostImage::kBorder;
    cost_.unit_px = static_cast<float>(truncation_px_) / 255.0f;
    cost_.pairs.assign(static_cast<std::size_t>(cost_.stride) *
                           static_cast<std::size_t>(size.height + 2 * CostImage::kBorder),
                       CostImage::kFar);
    tiles_x_ = (size.width + kTile_px - 1) / kTile_px;
    tiles_y_ = (size.height + kTile_px - 1) / kTile_px;
    for (auto* tiles : {&cost_wanted_, &cost_done_, &mask_wanted_, &mask_done_})
        tiles->assign(static_cast<std::size_t>(tiles_x_) * static_cast<std::size_t>(tiles_y_), 0);
    const std::size_t area = static_cast<std::size_t>(size.area());
    gray_.resize(area);
    mask_.resize(area);
    ridge_.reserve(static_cast<std::size_t>(size.width * kTile_px));
    squared_.reserve(static_cast<std::size_t>(size.width * kTile_px));
    values_.reserve(squared_.capacity());
    transform_.reserve(size.width, std::min(size.height, kTile_px + 2 * truncation_px_), truncation_px_);
    filter_.reserve(size.width, std::min(size.height, kTile_px));
}

cv::Rect CostImageMaker::pixels(const Run& run) const {
    return cv::Rect(run.first * kTile_px, run.row * kTile_px, (run.last - run.first) * kTile_px, kTile_px) &
           cv::Rect(0, 0, cost_.width, cost_.height);
}

cv::Rect CostImageMaker::tiles_of(const cv::Rect& region) const {
    const cv::Rect inside = region & cv::Rect(0, 0, cost_.width, cost_.height);
    if (inside.empty()) return {};
    const int x = inside.x / kTile_px, y = inside.y / kTile_px;
    return {x, y, (inside.br().x - 1) / kTile_px - x + 1, (inside.br().y - 1) / kTile_px - y + 1};
}

/// Calls task(run) for every longest row of neighbouring tiles i with is_in(i).
template <typename IsIn, typename Task>
void CostImageMaker::for_each_run(IsIn&& is_in, Task&& task) const {
    for (int row = 0; row < tiles_y_; ++row) {
        const auto at = [&](int x) { return is_in(static_cast<std::size_t>(row * tiles_x_ + x)); };
        for (int first = 0; first < tiles_x_; ++first) {
            int last = first;
            while (last < tiles_x_ && at(last)) ++last;
            if (last > first) task(Run{row, first, last});
            first = last;
        }
    }
}

void CostImageMaker::begin(const cv::Mat& picture) {
    if (picture.empty() || (picture.type() != CV_8UC1 && picture.type() != CV_8UC3))
        throw std::invalid_argument(
            "an image that is neither 8-bit gray nor 8-bit BGR, expected one of them");
    if (picture.cols != cost_.width || picture.rows != cost_.height) make_room(picture.size());
    picture_ = picture;
    forget_costs();
    for (auto* tiles : {&mask_wanted_, &mask_done_}) std::fill(tiles->begin(), tiles->end(), std::uint8_t{0});
}

void CostImageMaker::forget_costs() {
    for_each_run([this](std::size_t i) { return cost_done_[i] != 0; },
                 [this](const Run& run) {
                     const cv::Rect region = pixels(run);
                     for (int y = region.y - 1; y < region.br().y; ++y)
                         std::fill_n(cost_.row(y) + region.x, region.width, CostImage::kFar);
                 });
    for (auto* tiles : {&cost_wanted_, &cost_done_}) std::fill(tiles->begin(), tiles->end(), std::uint8_t{0});
}

void CostImageMaker::set_truncation(int truncation_px) {
    truncation_px_ = truncation_px;
    cost_.unit_px = static_cast<float>(truncation_px_) / 255.0f;
    transform_.reserve(cost_.width, std::min(cost_.height, kTile_px + 2 * truncation_px_), truncation_px_);
    forget_costs();
}

void CostImageMaker::want(const cv::Rect& region) {
    // Bilinear look-ups read the next pixel too.
    const cv::Rect tiles = tiles_of(grown(region, 1, cost_.width, cost_.height));
    for (int y = tiles.y; y < tiles.br().y; ++y)
        for (int x = tiles.x; x < tiles.br().x; ++x)
            cost_wanted_[static_cast<std::size_t>(y * tiles_x_ + x)] = 1;
}

void CostImageMaker::compute() {
    // A distance needs the ridges as far around as it can be.
    for (int y = 0; y < tiles_y_; ++y)
        for (int x = 0; x < tiles_x_; ++x) {
            const std::size_t i = static_cast<std::size_t>(y * tiles_x_ + x);
            if (!cost_wanted_[i] || cost_done_[i]) continue;
            const cv::Rect around =
                tiles_of(grown(pixels({y, x, x + 1}), truncation_px_, cost_.width, cost_.height));
            for (int v = around.y; v < around.br().y; ++v)
                for (int u = around.x; u < around.br().x; ++u)
                    mask_wanted_[static_cast<std::size_t>(v * tiles_x_ + u)] = 1;
        }
    for_each_run([this](std::size_t i) { return mask_wanted_[i] && !mask_done_[i]; },
                 [this](const Run& run) { detect(pixels(run)); });
    mask_done_ = mask_wanted_;
    for_each_run([this](std::size_t i) { return cost_wanted_[i] && !cost_done_[i]; },
                 [this](const Run& run) { to_distance(pixels(run)); });
    cost_done_ = cost_wanted_;
}

const CostImage& CostImageMaker::make(const cv::Mat& picture, const cv::Rect& region) {
    begin(picture);
    want(region);
    compute();
    return cost_;
}

/// Ridges of `region` into the mask.
void CostImageMaker::detect(const cv::Rect& region) {
    to_gray(grown(region, filter_.reach_px(), cost_.width, cost_.height));
    filter_.apply(gray_.data(), cost_.width, cost_.height, static_cast<std::size_t>(cost_.width), region,
                  ridge_);
    const std::size_t width = static_cast<std::size_t>(region.width);
    for (int y = 0; y < region.height; ++y) {
        const float* from = ridge_.data() + static_cast<std::size_t>(y) * width;
        std::uint8_t* to = mask_.data() + static_cast<std::ptrdiff_t>(region.y + y) * cost_.width + region.x;
        for (std::size_t x = 0; x < width; ++x) to[x] = from[x] > threshold_ ? 255 : 0;
    }
}

/// Costs of `region` from the mask around it.
void CostImageMaker::to_distance(const cv::Rect& region) {
    const cv::Rect around = grown(region, truncation_px_, cost_.width, cost_.height);
    squared_.resize(static_cast<std::size_t>(region.area()));
    transform_.apply(mask_.data() + static_cast<std::ptrdiff_t>(around.y) * cost_.width + around.x,
                     cost_.width, around.width, around.height, truncation_px_,
                     {region.x - around.x, region.y - around.y, region.width, region.height}, squared_.data(),
                     region.width);
    to_cost(region);
}

void CostImageMaker::to_gray(const cv::Rect& region) {
    const cv::Mat& picture = picture_;
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

void CostImageMaker::to_cost(const cv::Rect& region) {
    values_.resize(squared_.size());
    to_steps(squared_, 1.0f / cost_.unit_px, values_);
    // Every row goes to two rows of pairs: its own and, as what lies below, the one above.
    const std::size_t width = static_cast<std::size_t>(region.width);
    for (int y = -1; y < region.height; ++y) {
        std::uint16_t* pairs = cost_.row(region.y + y) + region.x;
        const std::uint8_t* below = values_.data() + static_cast<std::size_t>(y + 1) * width;
        const std::uint8_t* here = y < 0 ? below : below - width;
        if (y < 0)
            for (std::size_t x = 0; x < width; ++x)
                pairs[x] = static_cast<std::uint16_t>((pairs[x] & 255) | below[x] << 8);
        else if (y + 1 == region.height)
            for (std::size_t x = 0; x < width; ++x)
                pairs[x] = static_cast<std::uint16_t>((pairs[x] & 0xff00) | here[x]);
        else
            for (std::size_t x = 0; x < width; ++x)
                pairs[x] = static_cast<std::uint16_t>(here[x] | below[x] << 8);
    }
}

CostImageMaker::Pictures CostImageMaker::pictures() const {
    CostImageMaker whole = *this;
    RidgeFilterOptions every_value = filter_.options();
    every_value.floor = 0.0;
    whole.filter_ = RidgeFilter(every_value);
    const cv::Rect all(0, 0, cost_.width, cost_.height);
    whole.make(picture_, all);
    Pictures pictures;
    pictures.gray = cv::Mat(cost_.height, cost_.width, CV_32F, whole.gray_.data()).clone();
    pictures.mask = cv::Mat(cost_.height, cost_.width, CV_8U, whole.mask_.data()).clone();
    pictures.cost.create(cost_.height, cost_.width, CV_8U);
    for (int y = 0; y < cost_.height; ++y)
        for (int x = 0; x < cost_.width; ++x)
            pictures.cost.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(whole.cost_.row(y)[x] & 255);
    whole.filter_.apply(whole.gray_.data(), cost_.width, cost_.height, static_cast<std::size_t>(cost_.width),
                        all, whole.ridge_);
    pictures.ridge = cv::Mat(cost_.height, cost_.width, CV_32F, whole.ridge_.data()).clone();
    return pictures;
}

}  // namespace atropos::tracker
