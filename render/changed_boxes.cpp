#include "render/changed_boxes.hpp"

#include <algorithm>
#include <cstring>

namespace atropos::render {
namespace {

struct Extent {
    int left = 1 << 30, right = -1, top = 1 << 30, bottom = -1;

    void include(int x, int y) {
        left = std::min(left, x);
        right = std::max(right, x);
        top = std::min(top, y);
        bottom = std::max(bottom, y);
    }
};

}  // namespace

LabelBoxes boxes_of_changes(std::span<const std::uint8_t> labels, std::span<const std::uint8_t> at_rest,
                            int width) {
    constexpr int kBlock = 32;  // compared at once: most of a picture is at rest
    const int height = static_cast<int>(labels.size()) / width;
    LabelBoxes boxes;
    for (int eye = 0; eye < 2; ++eye) {
        std::array<Extent, 256> extents;
        const int end = (eye + 1) * (width / 2);
        for (int y = 0; y < height; ++y) {
            const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
            const std::uint8_t *now = labels.data() + row, *before = at_rest.data() + row;
            for (int x = eye * (width / 2); x < end;) {
                const int block = std::min(kBlock, end - x);
                if (std::memcmp(now + x, before + x, static_cast<std::size_t>(block)) != 0) {
                    for (int i = x; i < x + block; ++i)
                        if (now[i] != before[i]) extents[now[i]].include(i, y);
                }
                x += block;
            }
        }
        for (std::size_t label = 0; label < extents.size(); ++label) {
            const Extent& e = extents[label];
            if (e.right < 0) continue;
            boxes[{eye, static_cast<std::uint8_t>(label)}] =
                cv::Rect(cv::Point(e.left, e.top), cv::Point(e.right + 1, e.bottom + 1));
        }
    }
    return boxes;
}

std::array<std::vector<cv::Rect>, 2> by_eye(const LabelBoxes& before, const LabelBoxes& now) {
    LabelBoxes all = now;
    for (const auto& [key, box] : before) all[key] |= box;
    std::array<std::vector<cv::Rect>, 2> result;
    for (const auto& [key, box] : all) result[static_cast<std::size_t>(key.first)].push_back(box);
    return result;
}

}  // namespace atropos::render
