#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

namespace atropos::experiments {

/// What instruments look like against what lies around them: two histograms over hue, saturation and
/// brightness, learned from the frames themselves, nothing assumed of either.
class InstrumentColours {
  public:
    InstrumentColours();

    bool learned() const { return learned_; }

    /// `inside` and `outside`: masks of pixels that are surely of an instrument, surely of none.
    void learn(const cv::Mat& bgr, const cv::Mat& inside, const cv::Mat& outside);

    /// Probability of an instrument by pixel, CV_32F.
    cv::Mat probability(const cv::Mat& bgr) const;

  private:
    static constexpr int kLevels = 32, kChroma = 20, kBright = 3;
    static size_t level_index(const cv::Vec3b& bgr) {
        return (static_cast<size_t>(bgr[2] / 8) * kLevels + bgr[1] / 8) * kLevels + bgr[0] / 8;
    }
    std::vector<std::uint16_t> bin_;  // by level_index
    std::vector<double> inside_, outside_;
    std::vector<float> table_;  // probability by level_index
    bool learned_ = false;
};

}  // namespace atropos::experiments
