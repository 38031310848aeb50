#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace atropos::experiments {

/// COCO's uncompressed run lengths of a mask: columns first, beginning with a run of zeros (may be 0 long).
std::vector<int> coco_run_lengths(const cv::Mat1b& mask);

/// A dataset's left pictures as COCO: the thread's mask (RLE, area, box) and its key points (end_0, quarter,
/// middle, three_quarters, end_1 with v 0 not in the picture, 1 hidden, 2 visible). Needs the mask layer.
/// Throws scenes::FileError.
nlohmann::ordered_json coco_annotations(const std::filesystem::path& dataset,
                                        const std::vector<std::string>& sequences);

}  // namespace atropos::experiments
