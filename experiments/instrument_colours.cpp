#include "experiments/instrument_colours.hpp"

#include <algorithm>

namespace atropos::experiments {
namespace {

constexpr double kMemory = 0.6;  // of the counts before, each time it learns
constexpr int kStride = 2;
constexpr double kUnknown = 2e-4;  // share of pixels of a colour below which nothing is known

void count(const cv::Mat& bgr, const cv::Mat& mask, const std::vector<std::uint16_t>& bin,
           size_t (*index)(const cv::Vec3b&), std::vector<double>& histogram) {
    std::vector<double> now(histogram.size(), 0.0);
    double sum = 0.0;
    for (int y = 0; y < bgr.rows; y += kStride)
        for (int x = 0; x < bgr.cols; x += kStride)
            if (mask.at<std::uint8_t>(y, x)) {
                now[bin[index(bgr.at<cv::Vec3b>(y, x))]] += 1.0;
                sum += 1.0;
            }
    if (sum < 50.0) return;
    for (size_t i = 0; i < histogram.size(); ++i)
        histogram[i] = kMemory * histogram[i] + (1.0 - kMemory) * now[i] / sum;
}

}  // namespace

InstrumentColours::InstrumentColours()
    : bin_(static_cast<size_t>(kLevels) * kLevels * kLevels),
      inside_(static_cast<size_t>(kChroma) * kChroma * kBright, 0.0),
      outside_(inside_),
      table_(bin_.size(), 0.5f) {
    for (int r = 0; r < kLevels; ++r)
        for (int g = 0; g < kLevels; ++g)
            for (int b = 0; b < kLevels; ++b) {
                const double R = 8.0 * r + 8.0, G = 8.0 * g + 8.0, B = 8.0 * b + 8.0, sum = R + G + B;
                // Chromaticities lie around 1/3; what is beyond 0.1 and 0.7 falls into the outermost bins.
                const auto chroma = [](double share) {
                    return std::clamp(static_cast<int>((share - 0.1) / 0.6 * kChroma), 0, kChroma - 1);
                };
                const int bright = sum < 120.0 ? 0 : sum < 540.0 ? 1 : 2;
                bin_[(static_cast<size_t>(r) * kLevels + static_cast<size_t>(g)) * kLevels +
                     static_cast<size_t>(b)] =
                    static_cast<std::uint16_t>((chroma(R / sum) * kChroma + chroma(B / sum)) * kBright +
                                               bright);
            }
}

void InstrumentColours::learn(const cv::Mat& bgr, const cv::Mat& inside, const cv::Mat& outside) {
    count(bgr, inside, bin_, level_index, inside_);
    count(bgr, outside, bin_, level_index, outside_);
    for (size_t i = 0; i < table_.size(); ++i) {
        const double in = inside_[bin_[i]], out = outside_[bin_[i]];
        table_[i] = static_cast<float>((in + 0.5 * kUnknown) / (in + out + kUnknown));
    }
    learned_ = true;
}

cv::Mat InstrumentColours::probability(const cv::Mat& bgr) const {
    cv::Mat result(bgr.size(), CV_32F);
    for (int y = 0; y < bgr.rows; ++y) {
        const auto* pixel = bgr.ptr<cv::Vec3b>(y);
        auto* out = result.ptr<float>(y);
        for (int x = 0; x < bgr.cols; ++x) out[x] = table_[level_index(pixel[x])];
    }
    return result;
}

}  // namespace atropos::experiments
