#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <opencv2/core/types.hpp>
#include <span>
#include <utility>
#include <vector>

namespace atropos::render {

/// Boxes around the samples of each eye and label.
using LabelBoxes = std::map<std::pair<int, std::uint8_t>, cv::Rect>;

/// Where `labels` differ from `at_rest`; both eyes side by side, `width` samples a row.
LabelBoxes boxes_of_changes(std::span<const std::uint8_t> labels, std::span<const std::uint8_t> at_rest,
                            int width);

/// For each eye, what covers the boxes of two frames.
std::array<std::vector<cv::Rect>, 2> by_eye(const LabelBoxes& before, const LabelBoxes& now);

}  // namespace atropos::render
